"""The guard as it is exported: the parts of its graphs, and proof that the flag is enough."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property
from itertools import accumulate

import casadi as ca

from wmr_ctrl.control.controller import guard
from wmr_ctrl.control.guard.delay import InFlight, in_flight, largest_force
from wmr_ctrl.control.guard.guard import MAPS, Bounds, ceiling, clipped, feasible
from wmr_ctrl.control.guard.monitor import least_push
from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.world.model.dynamics import force_to_wheel, wheel_to_force
from wmr_ctrl.world.model.system import System
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.claim import CLAIMED, Claims, Mutation
from wmr_proofs.methods.spec import Z3
from wmr_proofs.relation import (
    Cuts,
    Relations,
    every,
    positive,
    when,
    within,
)
from wmr_proofs.statement import Statement, instance, valued
from wmr_proofs.symbols import Named, symbols

from .common import PRESET, named_ports, ports_of, scalars
from .guard_axis import DELAYED, NUMBERS, GuardAxis
from .guard_sample import anchor, largest
from .guard_sample import feasible as not_empty
from .guard_sample import inside as stays_inside
from .guard_sent import added, caps, room

PERIOD = 0.01
INSIDE = "|v| <= u1"
UNDER_WAY = (
    "v+ and -v+, where the new command takes over, are at most u1 and what the guard counts, v + "
    "ahead or -v + back, where ahead + back <= delay (largest + net)/M_min is what is under way "
    "(guard.assembled.carried, guard.delay.lemma)"
)
claim = Claims(by=Z3())


def setup(kind: str, delay: int, guarded: bool = True, **more: float) -> Setup:
    """A loop with this map onto the wheels, behind a delay of so many periods."""
    stated: dict[str, object] = {
        "guard.enabled": guarded, "guard.map": kind, "clock.control": PERIOD,
        "actuator.delay": PERIOD * delay, **more,
    }  # fmt: skip
    return settle(load_scenario(PRESET, stated), "pid")


class Assembled(Named):
    """A graph that is exported, and the numbers of its two axes as the claims' axes have them.

    ``p``: inputs, state and parameters by name; ``told``: published values besides the torques;
    ``asked``: the force that is asked for; ``wheels``: radius and half track; ``phi``: the wheels'
    reach; ``sent``: torques that are remembered, the last one first.
    """

    def __init__(self, assemble: Callable[[Setup], System], loop: Setup) -> None:
        self.setup, self.system = loop, assemble(loop)
        ports = ports_of(self.system)
        self.symbols = scalars(ports)
        self.p = p = named_ports(*ports)
        self.told = {output.signal.name: output.expr for output in self.system.diagnostics}
        self.torque = ca.vertcat(*(output.expr for output in self.system.outputs))
        self.asked = p["force"] if "force" in p else self.told["force"]
        self.wheels = p["robot.r"], p["robot.l"]
        self.phi = 2 * p["actuator.tau_max"] / self.wheels[0]
        kept = [name for name in p if name.startswith("tau_sent")]
        self.sent = [p[f"tau_sent{age}"] for age in range(1, len(kept) + 1)]

    @cached_property
    def axes(self) -> tuple[tuple[ca.SX, Bounds, InFlight | None], ...]:
        """Measured velocity, bounds and commands under way of each axis.

        u1 is v_u1 less (1 + n) 2^-44 of it.
        """
        names = ("M_min", "M_max", "dbar", "nbar", "brake", "f_min", "f_speed")
        p, T, found, delay = self.p, self.p["clock.control"], [], len(self.sent)
        late = {"delay": T * delay} if delay else {}
        before = [(wheel_to_force(*self.wheels, tau), 1) for tau in self.sent]
        for axis, y in enumerate((p["v1"], p["omega"])):
            u1 = p["limits.v_u1"][axis] * (1 - (1 + delay) * 2.0**-44)
            numbers = {name: p[f"guard.{name}"][axis] for name in names}
            b = Bounds(u1=u1, period=T, alpha=p["guard.alpha"], **numbers, **late)
            found.append((y, b, in_flight(before, axis, b) if before else None))
        return tuple(found)

    @cached_property
    def later(self) -> Cuts:
        """The state one sample later, by name."""
        ends = accumulate((port.sym.numel() for port in self.system.state), initial=0)
        names = [port.signal.name for port in self.system.state]
        return dict(zip(names, ca.vertsplit(self.system.update, [*ends]), strict=True))

    def consists(self, torque: ca.SX) -> Statement:
        """It consists of these torques, both axes' flags, its memory and the monitor's figure."""
        return Statement(self, tuple(self._parts(torque)), self.signs, self.cuts)

    def _parts(self, torque: ca.SX) -> Iterator[Relations]:
        bounds, half = [b for _, b, _ in self.axes], self.wheels[1]
        flags = [feasible(b) for b in bounds]
        flags.append(bounds[0].braking + bounds[1].braking / half <= self.phi)
        flags += self.slow_drives()
        yield from (flag >= self.told["feasible"] for flag in flags)
        yield from every(self.torque, torque)
        for age, now in enumerate((self.torque, *self.sent[:-1])[: len(self.sent)], 1):
            yield from every(self.later[f"tau_sent{age}"], now)
        yield from self.kept()
        yield from every(self.later["guard_v"], ca.vertcat(*(y for y, _, _ in self.axes)))
        for axis, known in enumerate(self.least_pushes()):
            yield self.told["d_least"][axis] == known

    def slow_drives(self) -> list[ca.SX]:
        """Conditions for the drives to be no slower than assumed."""
        if not self.sent:
            return []
        return [self.p["actuator.delay"] <= len(self.sent) * self.p["clock.control"]]

    def kept(self) -> Iterator[Relations]:
        """Memory beside the commands under way."""
        yield from every(self.later["tau_applied"], (self.torque, *self.sent)[-1])

    def least_pushes(self) -> Iterator[ca.SX]:
        """The monitor's figure of each axis."""
        acted = wheel_to_force(*self.wheels, self.p["tau_applied"])
        for axis, (y, b, _) in enumerate(self.axes):
            least = least_push(y, self.p["guard_v"][axis], acted[axis], b)
            yield ca.if_else(self.p["guard_started"] > 0, least, 0)

    @property
    def signs(self) -> Relations:
        """Signs of the divisors: all positive."""
        bounds = [b for _, b, _ in self.axes]
        masses = [mass for b in bounds for mass in (b.M_min, b.M_max)]
        return positive(*self.wheels, bounds[0].period, bounds[0].alpha, *masses)

    @property
    def cuts(self) -> Cuts:
        """Symbols that stand for the law's force, which may be any."""
        asked = {} if "force" in self.p else {"asked thrust": 0, "asked moment": 1}
        return {name: self.asked[axis] for name, axis in asked.items()}


_DELAYS = {
    "": {"delay": 0, "a": GuardAxis(), "at": "", "inside": INSIDE},
    "-delay": {
        "delay": 2, "a": GuardAxis(DELAYED), "at": "delay.", "inside": f"delay > 0; {UNDER_WAY}",
    },
}  # fmt: skip
EXPORTED = {f"{kind}{key}": {"kind": kind, **row} for kind in MAPS for key, row in _DELAYS.items()}
"""Both maps onto the wheels, without a delay and behind one of two periods."""


@claim(
    "guard.assembled",
    premises="guard.axes wheels.linear-first wheels.rotation-first",
    each=EXPORTED,
)
def assembled(mutation: Mutation, kind: str, delay: int) -> Statement:
    """the torques of the whole guard are those of the map, linear-first or rotation-first, on both
    axes' clips and safe points, each axis with its own bounds and its own commands under way (the
    torques sent before); feasible = 1 only if both axes' flags are 1, their brakes together are
    within the wheels' reach and the drives' delay is at most the one that is counted; the torque
    that is remembered as applied is the one that acts next, and each d_least is the monitor's value
    for it; without delay and behind one of two periods.

    The exported guard is composed of the parts that the other entries are about.

    Given: any parameters with r, l, T, alpha, M_min, M_max > 0; any force that is asked for.
    """
    return exported(mutation, kind, Assembled(guard, setup(kind, delay)))


def exported(mutation: Mutation, kind: str, e: Assembled) -> Statement:
    """It consists of the torques of its map on both axes' clips and safe points."""
    r, half = e.wheels
    force, safe = (
        ca.vertcat(*(clipped(part, *axis) for part, axis in zip(wish, e.axes, strict=True)))
        for wish in (ca.vertsplit(e.asked), (ca.SX(0), ca.SX(0)))
    )
    return e.consists(mutation * force_to_wheel(r, half, MAPS[kind](force, e.phi, half, safe)))


def begun(a: GuardAxis) -> tuple[ca.SX, ca.SX]:
    """Speed when the new command takes over, or f_speed if that is larger, ahead and back."""
    if a.lateness:
        return a.arrived_ahead, a.arrived_back
    return ca.fmax(a.v, a.f_speed), ca.fmax(-a.v, a.f_speed)


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


def stays(a: GuardAxis, force: ca.SX) -> Iterator[Relations]:
    """Goal: the speed stays inside with this force, forwards and backwards."""
    for way, start in zip((1, -1), begun(a), strict=True):
        yield a.u1 >= start + a.t * ca.fmax(way * force + a.net, 0) / a.mass


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
    way: v + t max(F + net, 0)/M <= u1 for t in [0, T], v the speed{where} or f_speed where that is
    more.

    The published flag alone, with what is physical, is enough for one axis.

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
    safe, chosen = a.force(ca.SX(0)), a.chosen
    within = ca.logic_and(chosen >= a.lo, chosen <= mutation(a.hi, 1.01 * a.hi))
    braked = a.bounds.braking >= safe, a.bounds.braking >= -safe
    goals = a.hi >= a.lo, braked, when(within, [*stays(a, chosen)])
    ahead, back = a.left
    cuts = {"hi": a.hi, "back": -a.lo, "room_ahead": ahead, "room_back": back} | a.cuts
    given = physical(a), feasible(a.bounds) > 0, taken
    return Statement(a, goals, given, cuts)


@claim(
    "guard.assembled.keeps",
    premises="guard.kept guard.delay.kept",
    each=EXPORTED,
)
def keeps(mutation: Mutation, kind: str, delay: int) -> Statement:
    """both axes, both ways: v + t max(F + net, 0)/M <= u1 for t in [0, T], F the exact force of the
    torques of the whole guard, with either map, v the speed or f_speed where that is more; for t =
    T that is |v| <= u1 again, where the next command takes over.

    From the published flag to the motion in one step, on the graph that is exported: a step of the
    induction over samples (guard.lemma). Nothing but feasible = 1 is asked of the guard's numbers.

    Given: feasible = 1; r, l, tau_max, T, alpha, u1, M_min > 0, dbar, nbar, brake, f_min, f_speed
    >= 0; any force asked for; of each axis |y - v| <= nbar, M_min <= M <= M_max; without delay
    {INSIDE}; behind one of two periods delay > 0, {UNDER_WAY}.
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
        back, hi = ceiling(-y, b, coming and coming.mirrored), ceiling(y, b, coming)
        parts = {"back": back, "hi": hi, "brakes": b.braking}
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

    What guard.assembled.keeps assumes of the commands under way is handed on from sample to sample.

    Given: feasible = 1; r, l, tau_max, T, delay, alpha, u1, M_min > 0, dbar, nbar, brake, f_min,
    f_speed >= 0; any velocities and any force asked for; behind one of two periods, |F_j| <=
    largest of both torques that are remembered and of both axes.
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
        wish = {"wish": e.asked[axis], "safe": ca.SX(0)}
        cuts |= {f"{key} {name}": clipped(part, y, b, coming) for key, part in wish.items()}
    return Statement(e | free, goals, given, cuts)
