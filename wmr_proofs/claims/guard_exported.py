"""The exported guard consists of its parts, and its flag is the only condition on its numbers."""

from collections.abc import Iterator
from dataclasses import replace

from casadi import SX, exp, fmax, logic_and, substitute, vertcat

from wmr_ctrl.control.controller import asking_controller, guard
from wmr_ctrl.control.guard.delay import largest_force
from wmr_ctrl.control.guard.guard import MAPS, ceiling, clipped, feasible
from wmr_ctrl.world.model.dynamics import wheel_to_force
from wmr_proofs.claim import CLAIMED, Claims, Mutation
from wmr_proofs.statement import (
    Relations,
    Statement,
    Symbols,
    every,
    instance,
    positive,
    symbols,
    valued,
    when,
    within,
)

from .command_filter import BY_SIDE, Keys
from .exported import PERIOD, Assembled, exported, setup
from .guard_axis import DELAYED, NUMBERS, GuardAxis
from .guard_sample import anchor, largest
from .guard_sample import feasible as not_empty
from .guard_sample import inside as stays_inside
from .guard_sent import added, caps, room

claim = Claims()


_DELAYS = {
    "": {"delay": 0, "a": GuardAxis(), "at": "", "inside": "{V_INSIDE}"},
    "-delay": {
        "delay": 2, "a": GuardAxis(DELAYED), "at": "delay.", "inside": "delay > 0; {UNDER_WAY}",
    },
}  # fmt: skip
EXPORTED = {f"{kind}{key}": {"kind": kind, **row} for kind in MAPS for key, row in _DELAYS.items()}
"""Both maps onto the wheels, without a delay and behind one of two periods."""
TOLD = EXPORTED | {
    f"{name} by direction": row | {"stated": BY_SIDE} for name, row in EXPORTED.items()
}
"""These with one limit for both directions, and with a limit of each."""


@claim(
    "guard.assembled",
    premises="guard.axes wheels.linear-first wheels.rotation-first",
    each=TOLD,
)
def assembled(mutation: Mutation, kind: str, delay: int, stated: Keys | None = None) -> Statement:
    """the torques of the whole guard are those of the map, linear-first or rotation-first, on both
    axes' clips and safe points, each axis with its own bounds and its own commands in transit (the
    torques sent before); feasible = 1 only if both axes' flags are 1, their brakes together are
    within the wheels' reach and the drives' delay is at most the assumed one; the torque stored as
    applied is the one that acts next, and each d_least is the monitor's value for it; without delay
    and behind one of two periods.

    The exported guard consists of the parts in the other entries.

    Given: any parameters with r, l, T, alpha, M_min, M_max > 0; any requested force; {OWN_LIMITS}.
    """
    return exported(mutation, kind, Assembled(guard, setup(kind, delay, **(stated or {}))))


def begun(a: GuardAxis) -> tuple[SX, SX]:
    """Speed when the new command takes over, or f_speed if that is larger, ahead and back."""
    if a.lateness:
        return a.arrived_ahead, a.arrived_back
    return fmax(a.v, a.f_speed), fmax(-a.v, a.f_speed)


def physical(a: GuardAxis) -> Relations:
    """Hypotheses: signs, and a sample that begins inside, at once or behind a delay."""
    known = a.signs, a.measured, a.during()
    if not a.lateness:
        return known, a.inside
    limits: list[Relations] = []
    for way, start in zip((1, -1), begun(a), strict=True):
        limits += a.u1 >= start, a.reached(way) >= start
        limits.append(start >= a.f_speed)
    return known, a.moving, limits, added(a)


def stays(a: GuardAxis, force: SX) -> Iterator[Relations]:
    """Goal: the speed stays inside with this force, forwards and backwards."""
    for way, start in zip((1, -1), begun(a), strict=True):
        yield a.u1 >= start + a.t * fmax(way * force + a.net, 0) / a.mass


@claim(
    "guard.{at}kept",

    premises="{parts}",
    over=(
        _DELAYS[""] | {"where": "", "parts": "guard.feasible guard.anchor guard.inside"},
        _DELAYS["-delay"] | {
            "where": " where the new command takes over",
            "parts": "guard.delay.caps guard.delay.room guard.delay.feasible guard.delay.anchor "
            "guard.delay.inside",
        },
    ),
)  # fmt: skip
def kept(mutation: Mutation, a: GuardAxis) -> Statement:
    """lo <= hi, |clip(0, lo, hi)| <= brakes, and every force F from lo to hi keeps the limit either
    way: v + t max(F + net, 0)/M <= u1 for t in [0, T], v the speed{where} or f_speed if that is
    larger.

    The published flag, with the physical hypotheses, is enough for one axis.

    Given: feasible = 1; T, alpha, u1, M_min > 0, dbar, nbar, brake, f_min, f_speed >= 0; |y - v| <=
    nbar, M_min <= M <= M_max; {inside}.
    """
    # The premises, each of which says when it holds, with the force in the place of what is asked.
    known = [not_empty(CLAIMED, a), anchor(CLAIMED, a)]
    if a.lateness:
        known += [caps(CLAIMED, a), room(CLAIMED, a)]
    taken = [instance(item, {}) for item in known]
    for way, start in zip((1, -1), ("arrived_ahead", "arrived_back"), strict=True):
        taken.append(
            instance(stays_inside(CLAIMED, way, a), {"arrived": a[start], "asked": a.chosen})
        )
    safe, chosen = a.force(SX(0)), a.chosen
    within = logic_and(chosen >= a.lo, chosen <= mutation(a.hi, 1.01 * a.hi))
    braked = a.bounds.braking >= safe, a.bounds.braking >= -safe
    goals = a.hi >= a.lo, braked, when(within, [*stays(a, chosen)])
    ahead, back = a.left
    cuts = {"hi": a.hi, "back": -a.lo, "room_ahead": ahead, "room_back": back} | a.cuts
    given = physical(a), feasible(a.bounds) > 0, taken
    return Statement(a, goals, given, cuts)


@claim("guard.assembled.keeps", premises="guard.kept guard.delay.kept", each=EXPORTED)
def keeps(mutation: Mutation, kind: str, delay: int) -> Statement:
    """both axes, both ways: v + t max(F + net, 0)/M <= u1 for t in [0, T], F the exact force of the
    torques of the whole guard, with either map, v the speed or f_speed if that is larger; for t = T
    that is |v| <= u1 again, when the next command takes over.

    From the published flag to the motion in one step, on the exported graph: a step of the
    induction over samples (guard.lemma).  The only condition on the guard's numbers is feasible =
    1.

    Given: feasible = 1; r, l, tau_max, T, alpha, u1, M_min > 0, dbar, nbar, brake, f_min, f_speed
    >= 0; any requested force; of each axis |y - v| <= nbar, M_min <= M <= M_max; without delay
    {V_INSIDE}; behind one of two periods delay > 0, {UNDER_WAY}; {ONE_LIMIT}.
    """
    e = Assembled(guard, setup(kind, delay))
    r, half = e.wheels
    force = wheel_to_force(r, half, e.torque)
    goals: list[Relations] = []
    given, cuts = list[Relations]([e.told["feasible"] > 0]), dict(e.cuts)
    given.append(positive(r, half, e.p["actuator.tau_max"]))
    table = e | symbols("t")
    for axis, (y, b, coming) in enumerate(e.axes):
        a = GuardAxis(DELAYED) if coming else GuardAxis()
        own = symbols("v mass arrived_ahead arrived_back")
        table |= {f"{name} {axis + 1}": value for name, value in own.items()}
        sums = {"ahead": coming.ahead, "back": coming.back} if coming else {}
        names = (*NUMBERS.split(), *["delay"] * bool(coming))
        values = {name: getattr(b, name) for name in names} | sums | own
        values |= {"y": y, "t": table["t"], "chosen": force[axis]}
        # The premise's own premises are no hypotheses of it.
        known = physical(a)
        alone = replace(kept(CLAIMED, a), given=(known, feasible(a.bounds) > 0))
        given += [valued(known, a, values), instance(alone, values)]
        goals += valued([*stays(a, mutation * a.chosen)], a, values)
        hi = ceiling(y, b, coming)
        parts = {"back": ceiling(-y, b, coming and coming.mirrored), "hi": hi, "brakes": b.braking}
        parts |= {f"sum {name}": total for name, total in sums.items()}
        cuts |= {f"{name} {axis + 1}": part for name, part in parts.items()}
    return Statement(table, goals, given, cuts)


@claim(
    "guard.assembled.carried",
    premises="guard.delay.caps guard.delay.largest guard.delay.anchor",
    each={kind: {"kind": kind} for kind in MAPS},
)
def carried(mutation: Mutation, kind: str) -> Statement:
    """ahead + back <= delay (largest + net)/M_min, and |F| <= largest, F the exact force of the
    torques of the whole guard, with either map; both axes.

    The assumptions of guard.assembled.keeps about commands in transit hold again at the next
    sample.

    Given: feasible = 1; r, l, tau_max, T, delay, alpha, u1, M_min > 0, dbar, nbar, brake, f_min,
    f_speed >= 0; any velocities and any requested force; behind one of two periods, |F_j| <=
    largest of both torques that are remembered and of both axes; {ONE_LIMIT}.
    """
    e = Assembled(guard, setup(kind, 2))
    free, force = symbols("linear angular"), wheel_to_force(*e.wheels, e.torque)
    given = list[Relations]([e.told["feasible"] > 0])
    given.append(positive(*e.wheels, e.p["actuator.tau_max"]))
    goals, cuts, a = list[Relations](), dict(e.cuts), GuardAxis(DELAYED)
    for axis, (y, b, coming) in enumerate(e.axes):
        assert coming is not None
        assert b.delay is not None
        name, most = (*free.items(),)[axis]
        values = {number: getattr(b, number) for number in (*NUMBERS.split(), "delay")}
        values |= {"y": y, "asked": e.asked[axis], "ahead": coming.ahead, "back": coming.back}
        given += valued(a.signs, a, values), most == largest_force(b)
        given += [instance(item(CLAIMED, a), values) for item in (caps, largest, anchor)]
        for age, tau in enumerate(e.sent):
            before = wheel_to_force(*e.wheels, tau)[axis]
            given += within(before, most)
            cuts[f"sent {name} {age}"] = before
        sums = b.delay * (most + b.dbar - b.f_min) / b.M_min
        goals.append(sums >= coming.ahead + coming.back)
        goals += within(force[axis], mutation(1, 0.99) * most)
        wish = {"wish": e.asked[axis], "safe": SX(0)}
        cuts |= {f"{key} {name}": clipped(part, y, b, coming) for key, part in wish.items()}
    return Statement(e | free, goals, given, cuts)


STEADY = {
    "sensor.velocity_window": PERIOD, "actuator.delay": 0.5 * PERIOD, "actuator.lag": 0.4 * PERIOD,
}  # fmt: skip
VARYING = STEADY | {"actuator.lag_spread": 0.25}
JITTER = {"actuator.jitter": 0.5 * PERIOD}

WAYS_TO_BE_LATE = {
    "steady": STEADY, "jitter": STEADY | JITTER,
    "varying-steady": VARYING, "varying": VARYING | JITTER,
}  # fmt: skip
EXPORTED_LATE = {
    f"{kind}-{late}": {"kind": kind, "stated": stated}
    for kind in MAPS
    for late, stated in WAYS_TO_BE_LATE.items()
}


@claim(
    "guard.assembled.late",
    premises="guard.axes wheels.linear-first wheels.rotation-first",
    each=EXPORTED_LATE,
)
def late(mutation: Mutation, kind: str, stated: Keys) -> Statement:
    """the torques of the whole guard are those of the map, linear-first or rotation-first, on both
    axes' clips and safe points, each axis with its own bounds and sums over commands in transit:
    piece by piece, with either of two commands, and with a stored sum of older ones, which is
    updated accordingly; feasible = 1 only if both axes' flags are 1, their brakes together are
    within reach and the drives are no later, slower, earlier or more variable than assumed; each
    d_least is that of the monitor for late motion; without jitter and with one of half a period,
    the lag constant and varying by a quarter.

    The exported guard consists of the parts in the entries about late velocities, jitter and lags.

    Given: any parameters with r, l, T, alpha, M_min, M_max, lag > 0, spread < 1; any requested
    force; velocities are means over a period, a delay of half of one, a lag of 0.4 of it;
    {ONE_LIMIT}.
    """
    return exported(mutation, kind, Assembled(guard, setup(kind, 0, **stated)))


LAG, PART = {"actuator.lag": 0.4 * PERIOD}, {"actuator.delay": 0.5 * PERIOD}


@claim(
    "guard.assembled.alone",

    premises="guard.axes wheels.linear-first",
    each={
        "lag": {"stated": LAG}, "varying-lag": {"stated": LAG | {"actuator.lag_spread": 0.25}},
        "delay": {"stated": PART}, "jitter": {"stated": JITTER},
        "window": {"stated": {"sensor.velocity_window": PERIOD}},
        "lag by direction": {"stated": LAG | BY_SIDE},
    },
)  # fmt: skip
def alone(mutation: Mutation, stated: Keys) -> Statement:
    """nothing is late but one of: a lag of 0.4 of a period; one that varies by a quarter; a delay
    of half a period; a jitter of that; velocities, which are means over a period.  The torques of
    the whole guard are those of linear-first on both axes' clips and safe points, with the sums
    over commands in transit and, behind a lag, over older ones, which the new command joins as it
    was sent to the wheels; feasible = 1 only if both axes' flags are 1, their brakes together are
    within reach and the drives are no later, slower or more variable than assumed; each d_least is
    the monitor's, behind a constant lag or delay for the torque stored as applied, else for late
    motion.

    Each kind of lateness alone is treated as it is together with the others.

    Given: any parameters with r, l, T, alpha, M_min, M_max > 0, and lag, 1 - spread > 0 where there
    is one; any requested force; {ONE_LIMIT}, or, behind a constant lag, one of each.
    """
    return exported(mutation, "linear-first", Assembled(guard, setup("linear-first", 0, **stated)))


@claim(
    "guard.assembled.controller{late}",

    over=(
        {"late": "", "more": "", "each": TOLD, "sided": "{OWN_LIMITS}",
         "which": "without delay and behind one of two periods"},
        {"late": "-late", "more": ", lag, 1 - spread > 0, 0 < exp(-h/lag) < 1",
         "each": EXPORTED_LATE, "sided": "{ONE_LIMIT}",
         "which": "late in the ways of guard.assembled.late"},
    ),
)  # fmt: skip
def controller(
    mutation: Mutation, kind: str, delay: int = 0, stated: Keys | None = None
) -> Statement:
    """torques, flag, d_least and the guard's memory one sample later are, in the whole controller,
    those of the whole guard on the force that the law requests: with either map, {which}.

    Results about the exported guard hold for it inside the controller.

    Given: any parameters with r, l, T, alpha, M_min, M_max > 0{more}; any measurements, targets and
    state; {sided}.
    """
    loop = setup(kind, delay, **(stated or {}))
    whole, alone = (Assembled(make, loop) for make in (asking_controller, guard))
    put = [whole.asked if name == "force" else whole.p[name] for name in alone.p]
    told = "feasible", "d_least"
    theirs, ours = (
        vertcat(
            *(e.later[name] for name in alone.later), *(e.told[name] for name in told), e.torque
        )
        for e in (whole, alone)
    )
    ours = substitute(ours, vertcat(*alone.p.values()), vertcat(*put))
    free = symbols("e") if "actuator.lag" in whole.p else Symbols()
    share = {name: exp(-whole.p["clock.plant"] / whole.p["actuator.lag"]) for name in free}
    below = (item for e in free.values() for item in (e > 0, e < 1))
    given = (whole.signs, *below)
    return Statement(whole | free, every(mutation * theirs, ours), given, whole.cuts | share)
