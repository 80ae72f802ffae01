"""The guard assembled: the graphs that are exported, axes, flag, monitor, and what is simulated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate

import casadi as ca

from wmr_ctrl.control.controller import asking_controller, guard
from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.guard.delay import InFlight, in_flight
from wmr_ctrl.guard.guard import MAPS, Bounds, ceiling, clipped, feasible, guarded
from wmr_ctrl.guard.lateness import AT_ONCE, Since
from wmr_ctrl.guard.monitor import LateMotion, least_push
from wmr_ctrl.model.dynamics import force_to_wheel, plant, rk4_step, wheel_to_force
from wmr_ctrl.model.system import System
from wmr_ctrl.proofs.claim import CLAIMED, Claims, Mutation
from wmr_ctrl.proofs.claims.common import PRESET, scalars
from wmr_ctrl.proofs.claims.guard import NUMBERS_FREE, anchor, solver, upper
from wmr_ctrl.proofs.claims.guard import feasible as not_empty
from wmr_ctrl.proofs.claims.guard_axis import DELAYED, LATE, NUMBERS, GuardAxis
from wmr_ctrl.proofs.claims.guard_sent import added, caps, room
from wmr_ctrl.proofs.statement import (
    Statement,
    above,
    at_least,
    equal,
    every,
    instance,
    positive,
    symbols,
    valued,
    when,
)
from wmr_ctrl.scenario import load_scenario

PERIOD = 0.01
INSIDE = "|v| <= u1"
UNDER_WAY = (
    "v+ and -v+, where the new command takes over, are at most u1 and what the guard counts, v + "
    "ahead or -v + back, where ahead + back <= delay (largest + net)/M_min is what is under way "
    "(guard.delay.command, guard.delay.queue, guard.delay.lemma)"
)
claim = Claims(by=solver)


def _setup(kind: str, delay: int) -> Setup:
    """A guarded loop with this map onto the wheels, behind a delay of so many periods."""
    stated: dict[str, object] = {
        "guard.enabled": True, "guard.map": kind, "clock.control": PERIOD,
        "actuator.delay": PERIOD * delay,
    }  # fmt: skip
    return settle(load_scenario(PRESET, stated), "pid")


@dataclass(frozen=True)
class Assembled:
    """A graph that is exported, and the numbers of its two axes as the claims' axes have them."""

    assemble: Callable[[Setup], System]
    kind: str
    delay: int

    @cached_property
    def system(self) -> System:
        """The exported graph."""
        return self.assemble(_setup(self.kind, self.delay))

    @cached_property
    def p(self) -> dict[str, ca.SX]:
        """Inputs, state and parameters by name."""
        ports = (*self.system.inputs, *self.system.state, *self.system.params)
        return {port.signal.name: port.sym for port in ports}

    @cached_property
    def told(self) -> dict[str, ca.SX]:
        """What it publishes beside the torques."""
        return {output.signal.name: output.expr for output in self.system.diagnostics}

    @property
    def asked(self) -> ca.SX:
        """The force that is asked for."""
        return self.p["force"] if "force" in self.p else self.told["force"]

    @property
    def torque(self) -> ca.SX:
        """The torques."""
        return ca.vertcat(*(output.expr for output in self.system.outputs))

    @property
    def wheels(self) -> tuple[ca.SX, ca.SX]:
        """Radius and half track."""
        return self.p["robot.r"], self.p["robot.l"]

    @property
    def phi(self) -> ca.SX:
        """The wheels' reach, 2 tau_max/r."""
        return 2 * self.p["actuator.tau_max"] / self.wheels[0]

    @property
    def sent(self) -> list[ca.SX]:
        """Torques under way, the last one first."""
        return [self.p[f"tau_sent{k}"] for k in range(1, self.delay + 1)]

    @cached_property
    def axes(self) -> tuple[tuple[ca.SX, Bounds, InFlight | None], ...]:
        """Of each axis the measured velocity, its bounds, and what is under way.

        u1 is v_u1 less (1 + n) 2^-44 of it.
        """
        names = ("M_min", "M_max", "dbar", "nbar", "brake", "f_min", "f_speed")
        p, T, found = self.p, self.p["clock.control"], []
        late = {"delay": T * self.delay} if self.delay else {}
        before = [(wheel_to_force(*self.wheels, tau), 1) for tau in self.sent]
        for axis, y in enumerate((p["v1"], p["omega"])):
            u1 = p["limits.v_u1"][axis] * (1 - (1 + self.delay) * 2.0**-44)
            numbers = {name: p[f"guard.{name}"][axis] for name in names}
            b = Bounds(u1=u1, period=T, alpha=p["guard.alpha"], **numbers, **late)
            found.append((y, b, in_flight(before, axis, b) if before else None))
        return tuple(found)

    @property
    def symbols(self) -> dict[str, ca.SX]:
        """Every scalar of the graph by name."""
        return scalars((*self.system.inputs, *self.system.state, *self.system.params))

    @property
    def cuts(self) -> dict[str, ca.SX]:
        """What a law asks for stands for any force."""
        asked = {} if "force" in self.p else {"asked thrust": 0, "asked moment": 1}
        return {name: self.asked[axis] for name, axis in asked.items()}


_EXPORTED = [
    {"name": name, "kind": kind, "late": late, "which": which, "delay": delay,
     "assemble": assemble, **words}
    for name, assemble in (("guard", guard), ("controller", asking_controller))
    for kind in MAPS
    for late, delay, which, words in (
        ("", 0, "without delay", {"at": "", "inside": INSIDE}),
        ("-late", 2, "behind a delay of two periods",
         {"at": "delay.", "inside": UNDER_WAY}),
    )
]  # fmt: skip


@claim(
    "guard.assembled.{name}.{kind}{late}",
    given="any parameters with r, l, T, alpha, M_min, M_max > 0; any force that is asked for",
    premises="guard.axes wheels.{kind}",
    over=_EXPORTED,
)
def assembled(
    mutation: Mutation, assemble: Callable[[Setup], System], kind: str, delay: int
) -> Statement:
    """the torques of the whole {name} are those of {kind} on both axes' clips and safe points, each
    axis with its own bounds and commands under way, which are the torques of before; feasible = 1
    only where both axes' flags are, their brakes together are within reach and the drives' delay is
    at most what is counted; {which}.

    What is exported is put together of what the entries about the guard speak of.
    """
    e = Assembled(assemble, kind, delay)
    r, half = e.wheels
    force, safe = (
        ca.vertcat(*(clipped(part, *axis) for part, axis in zip(wish, e.axes, strict=True)))
        for wish in (ca.vertsplit(e.asked), (ca.SX(0), ca.SX(0)))
    )
    bounds = [b for _, b, _ in e.axes]
    torque = force_to_wheel(r, half, MAPS[kind](force, e.phi, half, safe))
    flags = [feasible(b) for b in bounds]
    flags.append(bounds[0].braking + bounds[1].braking / half <= e.phi)
    if delay:
        flags.append(e.p["actuator.delay"] <= delay * e.p["clock.control"])
    goals = [at_least(flag, e.told["feasible"]) for flag in flags]
    goals += every(e.torque, mutation * torque)
    ends = accumulate((port.sym.numel() for port in e.system.state), initial=0)
    names = [port.signal.name for port in e.system.state]
    later = dict(zip(names, ca.vertsplit(e.system.update, [*ends]), strict=True))
    for age, now in enumerate((e.torque, *e.sent[:-1])[:delay], 1):
        goals += every(later[f"tau_sent{age}"], now)
    masses = [mass for b in bounds for mass in (b.M_min, b.M_max)]
    given = positive(r, half, bounds[0].period, bounds[0].alpha, *masses)
    return Statement(e.symbols, tuple(goals), given, e.cuts)


@claim(
    "guard.{at}kept",
    given="feasible = 1; T, alpha, u1, M_min > 0, dbar, nbar, brake, f_min, f_speed >= 0; |y - v| "
    "<= nbar, M_min <= M <= M_max; {inside}",
    premises="{parts}",
    over=[
        {"at": "", "a": GuardAxis(), "where": "", "inside": INSIDE,
         "parts": "guard.feasible guard.anchor guard.upper guard.lower"},
        {"at": "delay.", "a": GuardAxis(DELAYED), "where": " where the new command takes over",
         "inside": f"delay > 0; {UNDER_WAY}",
         "parts": "guard.delay.caps guard.delay.room guard.delay.feasible guard.delay.anchor "
         "guard.delay.upper guard.delay.lower"},
    ],
)  # fmt: skip
def kept(mutation: Mutation, a: GuardAxis) -> Statement:
    """lo <= hi, |clip(0, lo, hi)| <= brakes, and every force F from lo to hi keeps the limit either
    way: v + t max(F + net, 0)/M <= u1 for t in [0, T], v the speed{where} or f_speed where that is
    more.

    The published flag alone, with what is physical, is enough for one axis.
    """
    # The premises, each of which says when it holds, with the force in the place of what is asked.
    known = [not_empty(CLAIMED, a), anchor(CLAIMED, a)]
    if a.lateness:
        known += [caps(CLAIMED, a), room(CLAIMED, a)]
    taken = [goal for item in known for goal in instance(item, {})]
    for way, start in zip((1, -1), ("arrived_ahead", "arrived_back"), strict=True):
        taken += instance(upper(CLAIMED, way, a), {"arrived": a[start], "asked": a["chosen"]})
    safe, chosen = a.force(ca.SX(0)), a["chosen"]
    within = ca.logic_and(chosen >= a.lo, chosen <= mutation(a.hi, 1.01 * a.hi))
    goals = (
        at_least(a.hi, a.lo), at_least(a.bounds.braking, safe), at_least(a.bounds.braking, -safe),
        *(when(within, goal) for goal in a.stays(chosen)),
    )  # fmt: skip
    ahead, back = a.left
    cuts = {"hi": a.hi, "back": -a.lo, "room_ahead": ahead, "room_back": back} | a.cuts
    sums = added(a) if a.lateness else ()
    given = (*a.driven, *sums, above(feasible(a.bounds)), *taken)
    return Statement(a.symbols, goals, given, cuts)


@claim(
    "guard.assembled.keeps.{name}.{kind}{late}",
    given="feasible = 1; r, l, tau_max, T, alpha, u1, M_min > 0, dbar, nbar, brake, f_min, f_speed "
    ">= 0; any force asked for; of each axis |y - v| <= nbar, M_min <= M <= M_max; {inside}",
    premises="guard.{at}kept",
    over=_EXPORTED,
)
def keeps(
    mutation: Mutation, assemble: Callable[[Setup], System], kind: str, delay: int
) -> Statement:
    """both axes, both ways: v + t max(F + net, 0)/M <= u1 for t in [0, T], F the exact force of the
    torques of the whole {name}, v the speed or f_speed where that is more; {kind}, {which}.

    From the published flag to the motion in one step, on the graph that is exported: nothing but
    feasible = 1 is asked of the guard's numbers.
    """
    e = Assembled(assemble, kind, delay)
    r, half = e.wheels
    force = wheel_to_force(r, half, e.torque)
    goals, given, cuts = [], [above(e.told["feasible"])], dict(e.cuts)
    given += positive(r, half, e.p["actuator.tau_max"])
    table = {**e.symbols, **symbols("t")}
    for axis, (y, b, coming) in enumerate(e.axes):
        a, own = (
            GuardAxis(DELAYED) if coming else GuardAxis(),
            symbols("v mass arrived_ahead arrived_back"),
        )
        table |= {f"{name} {axis + 1}": value for name, value in own.items()}
        sums = {"ahead": coming.ahead, "back": coming.back} if coming else {}
        names = (*NUMBERS.split(), *["delay"] * bool(coming))
        values = {name: getattr(b, name) for name in names} | sums | own
        values |= {"y": y, "t": table["t"], "chosen": force[axis]}
        physical = (*a.driven, *(added(a) if coming else ()))
        given += valued(physical, a.symbols, values)
        given += instance(
            replace(kept(CLAIMED, a), given=(*physical, above(feasible(a.bounds)))), values
        )
        goals += valued(a.stays(mutation * a["chosen"]), a.symbols, values)
        back, hi = ceiling(-y, b, coming and coming.mirrored), ceiling(y, b, coming)
        parts = {"back": back, "hi": hi, "brakes": b.braking}
        cuts |= {f"{name} {axis + 1}": part for name, part in parts.items()}
    return Statement(table, tuple(goals), tuple(given), cuts)


@claim("guard.axes", given="T > 0")
def axes(mutation: Mutation) -> Statement:
    """guarded(F, y)_i = clip of F_i at y_i with the bounds of axis i, and the safe point likewise,
    i = 1, 2.

    What is shown of one axis holds for each of the two.
    """
    one, two = GuardAxis(), GuardAxis()
    table = {f"{name}{k}": a[name] for k, a in ((1, one), (2, two)) for name in a.symbols}
    both = Bounds(**{name: ca.vertcat(one[name], two[name]) for name in NUMBERS.split()})
    result = guarded(ca.vertcat(one["asked"], two["asked"]), ca.vertcat(one["y"], two["y"]), both)
    goals = [
        goal
        for i, a in enumerate((one, two))
        for goal in (
            equal(result.force[i], clipped(mutation * a["asked"], a["y"], a.bounds)),
            equal(result.safe[i], clipped(ca.SX(0), a["y"], a.bounds)),
        )
    ]
    positive = tuple(above(a["period"]) for a in (one, two))
    return Statement(table, tuple(goals), positive)


@claim(
    "guard.{name}",
    given="{which}",
    over=(
        {"name": "promise", "a": GuardAxis(), "which": "without delay (delay = 0 in the claim)"},
        {"name": "promise-late", "a": GuardAxis(DELAYED), "which": "behind a delay"},
        {"name": "late.promise", "a": GuardAxis(LATE), "effort": 400,
         "which": "with jitter; and 2 net mixed <= M_min (u1 - 2 nbar)"},
    ),
)  # fmt: skip
def promise(mutation: Mutation, a: GuardAxis) -> Statement:
    """feasible = 1 implies 2 net (1 + alpha delay) <= M_min alpha (u1 - f_speed), 2 nbar <= u1,
    brake >= net, M_min <= M_max, f_speed < u1 and alpha T <= 1.

    The published flag stands for the theorem's hypotheses, signs aside.
    """
    b = a.bounds
    need = mutation(2, 2.01) * a.net * (1 + b.alpha * a.late)
    goals = (
        at_least(b.M_min * b.alpha * (b.u1 - b.f_speed), need),
        *([a.spread] if a.lateness == LATE else []),
        at_least(b.u1, 2 * b.nbar),
        at_least(b.brake, a.net),
        at_least(1, b.alpha * b.period),
        at_least(b.M_max, b.M_min),
        above(b.u1, b.f_speed),
    )
    return Statement(a.symbols, goals, (above(feasible(b)),))


@claim("guard.simulated", given="every mu >= 0, m, I, r, l, g, v_s, h > 0, all inputs")
def simulated(mutation: Mutation) -> Statement:
    """one Runge-Kutta step h of the plant ends at v1 <= max(v1 + h max(F, 0)/m, h (|F| + 2 mu m
    g)/m), F all that pushes; omega ends at omega + h N/I.

    The simulated robot does not outrun the comparison that the guard counts with, but for speeds
    that friction alone turns round within a step. This is over the real numbers: the step's own
    rounding, some units in the last place of v a step, is not counted, so the simulated v may pass
    u1 by so much.
    """
    robot = plant(load_scenario(PRESET))
    t = {**scalars((*robot.inputs, *robot.state, *robot.params)), **symbols("step", "step")}
    m, inertia, mu, r, half, g, v_s = (
        t[f"robot.{name}"] for name in ("m", "I", "mu", "r", "l", "g", "v_s")
    )
    tau = ca.vertcat(t["tau_right"] + t["noise_right"], t["tau_left"] + t["noise_left"])
    push = wheel_to_force(r, half, tau) + ca.vertcat(t["thrust"], t["moment"])
    after = rk4_step(robot, t["step"])[3:5]
    friction = mu * m * g
    driven = t["v1"] + t["step"] * ca.fmax(push[0], 0) / m
    slow = t["step"] * (ca.fabs(push[0]) + mutation(2, -1) * friction) / m
    goals = (
        at_least(ca.fmax(driven, slow), after[0]),
        equal(after[1], t["omega"] + t["step"] * push[1] / inertia),
    )
    positive = tuple(above(item) for item in (m, inertia, r, half, g, v_s, t["step"]))
    given = (*positive, at_least(mu))
    return Statement(t, goals, given, {"thrust in all": push[0], "moment in all": push[1]})


@claim(
    "guard.monitor",
    given=f"{NUMBERS_FREE}; push of either sign; both measured velocities beyond nbar on the "
    "same side, friction against the motion",
)
def not_blamed(mutation: Mutation) -> Statement:
    """d_least is at most the mean disturbance of the sample in the direction of motion, or 0,
    driving forwards or backwards.

    The monitor accuses the bounds only where they are wrong.
    """
    a = GuardAxis()
    b, t = a.bounds, symbols("old push drag e_new e_old way")
    way = ca.if_else(t["way"] > 0, 1, -1)
    mean = (a["asked"] + way * (t["push"] - mutation * t["drag"])) / a["mass"]
    new = t["old"] + b.period * mean
    y, before = new + t["e_new"], t["old"] + t["e_old"]
    errors = [at_least(b.nbar, side * t[name]) for side in (1, -1) for name in ("e_new", "e_old")]
    ahead = (above(ca.fmin(way * y, way * before), b.nbar), at_least(t["drag"]))
    least = least_push(y, before, a["asked"], b)
    given = (*a.feasible(), *a.during(), *errors, *ahead)
    return Statement({**a.symbols, **t}, (at_least(ca.fmax(t["push"], 0), least),), given)


@claim("guard.monitor-quiet", given="any bounds, T > 0")
def quiet(mutation: Mutation) -> Statement:
    """d_least = 0 where the measured velocities are not both beyond nbar on the same side.

    At rest and at a change of direction nothing is accused.
    """
    a = GuardAxis()
    b, old = a.bounds, ca.SX.sym("old")
    least = least_push(a["y"], old, a["asked"], b)
    same = ca.fmax(ca.fmin(a["y"], old), -ca.fmax(a["y"], old)) - mutation(0, 1)
    given = (above(b.period), above(b.M_min), at_least(b.nbar), at_least(b.nbar, same))
    return Statement({**a.symbols, "old": old}, (equal(least),), given)


@claim(
    "guard.monitor-sharp",
    given="nbar = 0, M_min = M_max = M, no friction, push >= 0 in the direction of motion",
)
def sharp(mutation: Mutation) -> Statement:
    """d_least is the push of the sample, forwards and backwards.

    Where nothing is uncertain the monitor measures the disturbance.
    """
    a = GuardAxis()
    b, t = a.bounds, symbols("old push way")
    way = ca.if_else(t["way"] > 0, 1, -1)
    y = t["old"] + b.period * (a["asked"] + way * t["push"]) / b.M_min
    least = least_push(y, t["old"], a["asked"], b)
    exact = (equal(b.nbar), equal(b.M_max, b.M_min), above(b.M_min), above(b.period))
    ahead = (above(ca.fmin(way * y, way * t["old"])), at_least(t["push"]))
    return Statement({**a.symbols, **t}, (equal(least, mutation * t["push"]),), (*exact, *ahead))


SINCE = Since(
    mean=(((1, 2), 0.5), ((2,), 0.25)),
    rest=(((1,), 0.5), ((1, 2), 0.75)),
    mean_time=0.75, rest_time=1.25, older=AT_ONCE,
)  # fmt: skip
"""Commands that may have acted: of mean either of two, then the older one; likewise of rest."""


@claim(
    "guard.monitor-late",
    given="mean: either of two commands for T/2, the older for T/4; rest: the newer for T/2, "
    "either for 3 T/4; no lag; M_min, T > 0, nbar, D >= 0; either axis",
)
def late(mutation: Mutation) -> Statement:
    """late velocities: d_least <= D where each way the velocity moved since the previous sample by
    no more than the commands that may have acted and a push D explain, as mean or from rest.

    The monitor accuses no bounds that explain the motion, behind a delay and jitter either.
    """
    a = GuardAxis()
    b, t = a.bounds, symbols("old D F1 F2 N1 N2")
    sent = [ca.vertcat(t[f"F{j}"], t[f"N{j}"]) for j in (1, 2)]
    motion, old, D = LateMotion((SINCE, SINCE), sent, sent[0]), t["old"], t["D"]
    goals, given = [], [above(b.M_min), above(b.period), at_least(b.nbar), at_least(D)]
    for axis, name in enumerate("FN"):
        least = motion.least_push(axis, a["y"], old, b)
        goals.append(at_least(D, mutation(1, 1.01) * least))
        for way in (1, -1):
            newer, older = (ca.fmax(way * t[f"{name}{j}"], 0) for j in (1, 2))
            either = ca.fmax(newer, older)
            mean = 0.5 * either + 0.25 * older + 0.75 * D
            rest = 0.5 * newer + 0.75 * either + 1.25 * D
            moved = b.M_min * (way * (a["y"] - old) - 2 * b.nbar) / b.period
            begun = b.M_min * (way * a["y"] - b.nbar) / b.period
            given.append(at_least(ca.fmax(mean - moved, rest - begun)))
    return Statement({**a.symbols, **t}, tuple(goals), tuple(given))
