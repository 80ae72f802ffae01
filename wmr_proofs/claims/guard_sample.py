"""The velocity guard: conditions that keep the limit, and the return to it from outside.

All parameters are symbols.  The statements are about one sample of one axis: without lateness,
behind a delay, with late velocities, jitter and lag, behind a varying lag.  Effects of commands in
transit are in `guard_sent`, which also shows that no guard does better and, by hand, what follows
for every instant of a run.
"""

from typing import Any

from casadi import SX, fmax, fmin

from wmr_proofs.claim import SHARED, Claims, Mutation
from wmr_proofs.statement import Relations, Statement

from .guard_axis import AT_ONCE, DELAYED, LAGGING, LATE, GuardAxis

KINDS: dict[str, dict[str, Any]] = {}
words: dict[str, Any] = {}
for at, axes in {
    "": {"": GuardAxis(AT_ONCE)}, "delay.": {"": GuardAxis(DELAYED)},
    "late.": {"jitter": GuardAxis(LATE), "steady": GuardAxis(LATE, varies=False)},
    "varying.": {"jitter": GuardAxis(LAGGING), "steady": GuardAxis(LAGGING, varies=False)},
}.items():  # fmt: skip
    words = words | SHARED["kinds"][at]
    KINDS[at] = words | {"axes": axes}
KINDS["late.steady."] = KINDS["late."] | {
    "only": "steady.", "axes": {"": GuardAxis(LATE, varies=False)},
}  # fmt: skip
"""Axes by how their ids begin, and what the claims' texts say of each."""
ALL = "", "delay.", "late.", "varying."
WAYS = {"forwards": {"way": 1}, "backwards": {"way": -1}}


def on(*kinds: str, back: bool = False) -> list[dict[str, Any]]:
    """Tables of a claim about these axes, forwards and, with ``back``, backwards."""
    found, ways = [], WAYS if back else {"": {"way": 1}}
    for kind in kinds:
        row = KINDS[kind]
        each = {f"{key}-{way}".strip("-"): {"a": a, **turned}
                for key, a in row["axes"].items() for way, turned in ways.items()}  # fmt: skip
        told = {"each": each} if len(each) > 1 else next(iter(each.values()))
        found.append(row | {"at": kind.removesuffix(row["only"]), **told})
    return found


claim = Claims()


@claim("guard.{at}feasible", premises="{rests}", over=on(*ALL))
def feasible(mutation: Mutation, a: GuardAxis) -> Statement:
    """lo(y) <= hi(y) for every y and any earlier commands.

    There is always a safe force, so no check is needed during a run.

    Given: {enough}.
    """
    return Statement(a, a.hi >= a.lo, a.can_brake(mutation(1, 1.01)), a.rooms)


@claim("guard.{at}largest", premises="guard.{at}caps", over=on("delay.", "late."))
def largest(mutation: Mutation, a: GuardAxis) -> Statement:
    """|F| <= largest.

    New commands satisfy the bound that was assumed for earlier ones.

    Given: {caps}.
    """
    most, force = mutation(1, 0.99) * a.largest, a.force(a.asked)
    goals = most >= force, most >= -force
    return Statement(a, goals, a.stated, a.rooms)


@claim("guard.{at}anchor", premises="{capped}", over=on("", "delay.", "late."))
def anchor(mutation: Mutation, a: GuardAxis) -> Statement:
    """|clip(0, lo, hi)| <= brakes = min(brake, cap).

    The smallest safe force is within the brake cap, so the wheel maps stay in the box.

    Given: {caps}.
    """
    most = mutation(1, 0.99) * a.bounds.braking
    return Statement(a, most >= abs(a.force(SX(0))), a.stated, a.rooms)


@claim("guard.{at}inside", premises="{kept}", over=on("", "delay.", "late.", back=True))
def inside(mutation: Mutation, way: int, a: GuardAxis) -> Statement:
    """v+ <= u1{where}: v+ + t max(F + net, 0)/M <= u1 as long as it acts, v+ = max(v, f_speed), for
    any requested force; and the same of -v and -F.

    A robot within its limit stays within it, forwards and backwards.

    Given: {inside}; {acts}.
    """
    return Statement(a, a.u1 >= a.then(way), a.kept(way, mutation(1, 1.01)), a.rooms)


@claim("guard.{at}outside", premises="{counts}", over=on(*ALL, back=True))
def outside(mutation: Mutation, way: int, a: GuardAxis) -> Statement:
    """{v} > u1{where}: F + net <= -min(brakes - net, M_max ({v} - u1)/T) <= 0; and the same of -v
    and -F.

    Outside the limit no disturbance can make the robot faster, once earlier commands have ceased to
    act.

    Given: {seen}{over}; {caps}{filled}.
    """
    b = a.bounds
    needed = fmin(b.braking - a.net, mutation(1, 1.01) * b.M_max * a.beyond(way) / b.period)
    goals = -a.push(way) >= 0, -a.push(way) >= needed
    return Statement(a, goals, a.outside(way), a.rooms if a.lateness == LAGGING else a.cuts)


@claim("guard.{at}{only}return", over=on("", "delay.", "late.steady.", back=True))
def return_step(mutation: Mutation, way: int, a: GuardAxis) -> Statement:
    """{v} > u1{where}: a sample later {v} <= max(u1, {v} - T (brakes - net)/M); and the same of
    -v.

    Once late commands have ceased to act, the robot is back within the limit after ceil(({v} - u1)
    M/(T (brakes - net))) samples, with {v} the speed at that time and M at worst M_max.

    Given: {seen}, M_min <= M <= M_max; {caps}{filled}.
    """
    b, mass, start = a.bounds, a.mass, a.start(way)
    step = b.period * (b.braking - a.net) / mass
    end = start + b.period * a.push(way) / mass
    goal = fmax(a.u1, start - mutation(1, 1.01) * step) >= end
    return Statement(a, goal, a.outside(way, a.during()), a.cuts)


@claim("guard.no-overshoot", over=on("", back=True))
def no_overshoot(mutation: Mutation, way: int) -> Statement:
    """f_speed + t max(net - F, 0)/M <= u1 and f_speed + t max(net + F, 0)/M <= u1, net = dbar -
    f_min, from every v, measured or not.

    Braking from outside never carries the robot beyond the other limit.

    Given: {caps}; {acts}.
    """
    a = GuardAxis()
    fallen = a.f_speed + a.t * fmax(a.net - way * a.force(a.asked), 0) / a.mass
    return Statement(a, mutation(a.u1, 0.99 * a.u1) >= fallen, (a.feasible(), a.during()))


@claim("guard.{at}graceful", over=on("", "delay.", back=True))
def graceful(mutation: Mutation, way: int, a: GuardAxis) -> Statement:
    """|d| <= dbar + D keeps v and -v <= u1 + D (T{late})/M_min.

    Under a push that exceeds its bound by D the speed exceeds the limit by at most a known amount.

    Given: {seen}, {acts}; {spare}; {caps}{filled}.
    """
    D = a.extra
    limit = a.exceeded(mutation(1, 0.99))
    begins = D >= 0, a.withstands(D), limit >= a.start(way)
    given = a.stated, a.seen(way, D * a.late / a.bounds.M_min, a.during()), begins, a.ordered(way)
    return Statement(a, limit >= a.then(way, D), given, a.cuts)


@claim("guard.{at}graceful", premises="guard.{at}left", over=on("late.", back=True))
def late_graceful(mutation: Mutation, way: int, a: GuardAxis) -> Statement:
    """|d| <= dbar + D keeps v+ <= u1 + D (T + late)/M_min, for v and -v.

    Under a push that exceeds its bound by D the speed exceeds the limit by at most a known amount.

    Given: guard.{at}left with D (late - J)/M_min more; {acts}, to the end of that; D >= 0, brakes -
    net >= D; {caps}.
    """
    # t at its end, as v is linear.
    b, D = a.bounds, a.extra
    limit = a.exceeded(mutation(1, 0.99))
    over, most = a.start(way, D), a.hi if way > 0 else -a.lo
    last = b.period + a.J - a.since
    end = over + last * fmax(most + a.net + D, 0) / a.mass
    free = a.arrived - D * (a.late - a.J) / b.M_min - b.u1
    known = a.sound(), a.capped, a.during(), a.arrived >= b.f_speed
    given = known, a.lines(way, a.room, -free), D >= 0, a.withstands(D), limit >= over
    return Statement(a, limit >= end, given, {**a.cuts, "room": a.left[0 if way > 0 else 1]})


@claim("guard.{at}left", over=on("late."))
def left(mutation: Mutation, a: GuardAxis) -> Statement:
    """room + J max(F_1 + net, 0)/M_min and (1 + alpha J) room are at most u1 less v+ when the new
    command may first take over; either way.

    Definition of the room.

    Given: {seen}; {SIGNS}, alpha T <= 1, 0 <= J <= T.
    """
    goals = list[Relations]()
    for left, way in zip(a.left, (1, -1), strict=True):
        goals += a.lines(way, left, a.u1 - mutation(1, 1.01) * a.reached(way))
    return Statement(a, goals, (a.sound(), a.measured, a.moving))
