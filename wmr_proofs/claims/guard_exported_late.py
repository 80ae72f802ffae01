"""The exported guard with late velocities and slow drives: which sums it takes, and how.

Sums and pushes are written down here for one piece of time after the other, as in the entries about
pieces (guard.late.piece, guard.late.tail, guard.varying.*). The length of a piece, and its weight,
are numbers of the scenario.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from math import ceil, inf, nextafter

import casadi as ca

from wmr_ctrl.control.controller import asking_controller, guard
from wmr_ctrl.control.guard.bounds import pair_of
from wmr_ctrl.control.guard.delay import (
    InFlight,
    Lagging,
    in_flight,
    integral,
    moved,
    push,
    waiting,
)
from wmr_ctrl.control.guard.guard import MAPS, Bounds
from wmr_ctrl.control.guard.lateness import Piece
from wmr_ctrl.control.guard.monitor import LateMotion
from wmr_ctrl.control.guard.varying import Passage
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.world.model.dynamics import wheel_to_force
from wmr_ctrl.world.model.system import System
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.methods.spec import Z3
from wmr_proofs.relation import Relations, every, positive
from wmr_proofs.statement import Statement
from wmr_proofs.symbols import Symbols, symbols

from .guard_exported import EXPORTED, PERIOD, Assembled, exported, setup

STEADY = {
    "sensor.velocity_window": PERIOD, "actuator.delay": 0.5 * PERIOD, "actuator.lag": 0.4 * PERIOD,
}  # fmt: skip
VARYING = STEADY | {"actuator.lag_spread": 0.25}
JITTER = {"actuator.jitter": 0.5 * PERIOD}
claim = Claims(by=Z3())


class LateAssembled(Assembled):
    """An exported graph whose velocities are means and whose drives are slow.

    ``counted``: weights of what was sent, the same on both axes; ``forces``: of what is remembered.
    """

    def __init__(self, assemble: Callable[[Setup], System], loop: Setup) -> None:
        super().__init__(assemble, loop)
        self.counted, second = loop.guard.lateness(loop.scenario.clock)
        assert self.counted == second
        self.forces = [wheel_to_force(*self.wheels, tau) for tau in self.sent]

    @cached_property
    def axes(self) -> tuple[tuple[ca.SX, Bounds, InFlight | None], ...]:
        """Measured velocity, bounds and commands in transit of each axis.

        u1 is v_u1 less (1 + n) 2^-44 of it, n the commands and the periods of the lag.
        """
        names = ("M_min", "M_max", "dbar", "nbar", "brake", "f_min", "f_speed")
        p, T, late = self.p, self.p["clock.control"], self.counted
        times = {"delay": late.most, "jitter": late.jitter, "mixed": late.mixed}
        lasting = {name: T * time for name, time in times.items() if time}
        kept = (1 + late.commands + ceil(late.lag)) * 2.0**-44
        sums, found = self._felt if late.varying else self._summed, []
        for axis, y in enumerate((p["v1"], p["omega"])):
            numbers = {name: p[f"guard.{name}"][axis] for name in names}
            u1, alpha = p["limits.v_u1"][axis] * (1 - kept), p["guard.alpha"]
            b = Bounds(u1=u1, period=T, alpha=alpha, **numbers, **lasting)
            found.append((y, b, sums(axis, b)))
        return tuple(found)

    def _summed(self, axis: int, b: Bounds) -> InFlight:
        late = self.counted
        mean, rest = (self._pieces(item, axis, b) for item in (late.mean, late.rest))
        tail, share = self._older(axis, b), late.tail.share if late.tail else 1.0
        ways = zip((mean.ahead, mean.back), (rest.ahead, rest.back), tail, strict=True)
        ahead, back = ((one + share * old, two + old) for one, two, old in ways)
        again = in_flight([(self.forces[0], late.jitter)], axis, b) if late.jitter else None
        from_rest = InFlight(ahead[1], back[1]) if late.averaged else None
        return InFlight(ahead[0], back[0], from_rest, again)

    def _pieces(self, pieces: Sequence[Piece], axis: int, b: Bounds) -> InFlight:
        forces = self.forces
        either = [ca.horzcat(*(forces[j - 1] for j in which)) for which, _ in pieces]
        return in_flight(list(zip(either, (time for _, time in pieces), strict=True)), axis, b)

    def _older(self, axis: int, b: Bounds) -> list[ca.SX]:
        """Remaining share of older commands, ahead and back."""
        tail = self.counted.tail
        if tail is None:
            return [ca.SX(0), ca.SX(0)]
        kept, steady = self.p["guard_tail"], tail.steady * b.period * ca.fmax(b.net, 0)
        return [(kept[2 * axis + k] + steady) / b.M_min for k in (0, 1)]

    def _felt(self, axis: int, b: Bounds) -> InFlight:
        late, T = self.counted, b.period
        varying, ways = late.varying, []
        assert varying is not None
        for k, way in enumerate((1, -1)):
            means, rests, z = self._followed(varying.pieces, self.forces, axis, b, k)
            left = T * varying.longest * z
            after, again = z, ca.SX(0)
            if late.jitter:
                p = push([self.forces[0][axis]], b, way)
                again = waiting(z, p, T * late.jitter, T * varying.rises[0]) / b.M_min
                after = moved(z, p, varying.stays)
            sums = ((total + left) / b.M_min for total in (means, rests))
            ways.append((*sums, again, z, after))
        ahead, back = ways
        mean, rest, last = (InFlight(ahead[k], back[k]) for k in range(3))
        now, after_both = ((ahead[k], back[k]) for k in (3, 4))
        slow = Lagging(now, after_both, T * varying.rises[1], T * varying.rises[2])
        return replace(
            mean, since_rest=rest if late.averaged else None,
            again=last if late.jitter else None, slow=slow,
        )  # fmt: skip

    def _followed(
        self, pieces: Sequence[Passage], forces: Sequence[ca.SX], axis: int, b: Bounds, k: int
    ) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Integrals of Z, for mean and rest, and its end value; ``forces``: the latest first."""
        z = self.p["guard_tail"][2 * axis + k] + ca.fmax(b.net, 0)
        mean = rest = ca.SX(0)
        for piece in pieces:
            p = push([forces[j - 1][axis] for j in piece.which], b, 1 - 2 * k)
            mean += b.period * integral(z, p, piece.mean)
            rest += b.period * integral(z, p, piece.rest)
            z = moved(z, p, piece.stays)
        return mean, rest, z

    def slow_drives(self) -> list[ca.SX]:
        """Conditions for the drives to be no slower, no sooner and no more varied than counted."""
        p, T, near = self.p, self.p["clock.control"], 1 + 2.0**-44
        delay, lag, spread = (p.get(f"actuator.{key}", 0) for key in ("delay", "lag", "lag_spread"))
        (least, most), (fast, slow) = map(pair_of, (self.setup.guard.delay, self.setup.guard.lag))
        met = []
        if most:
            met.append(delay + p.get("actuator.jitter", 0) <= _periods(most) * T)
        if slow:
            met.append(lag * (1 + spread) <= _periods(slow) * T)
        if least < most:
            met.append(delay * near >= _periods(least) * T)
        if fast < slow:
            step = p["clock.plant"]
            growth = ca.exp(step / (lag * (1 - spread))) - 1
            met.append(step >= _periods(fast) * T * growth)
        return met

    @property
    def signs(self) -> Relations:
        """Divisors are positive."""
        if not self.counted.lag:
            return super().signs
        lag, spread = self.p["actuator.lag"], self.p.get("actuator.lag_spread", ca.SX(0))
        return super().signs, positive(lag, 1 - spread)

    def kept(self) -> Iterator[Relations]:
        """Memory of older commands, of the guard and of the monitor."""
        if not self.counted.lag:
            return
        later = [self._joined(axis, b) for axis, (_, b, _) in enumerate(self.axes)]
        yield from every(self.later["guard_tail"], ca.vertcat(*later))
        if "guard_monitor_tail" in self.later:
            told = self._kept_as_named(self._motion.following(self._both))
            yield from every(self.later["guard_monitor_tail"], told)

    def _kept_as_named(self, expr: ca.SX) -> ca.SX:
        """An expression of the monitor's with the state of the exported graph."""
        kept = self._motion.tails.state
        return ca.substitute(expr, kept[0].sym, self.p["guard_monitor_tail"]) if kept else expr

    def _joined(self, axis: int, b: Bounds) -> ca.SX:
        """The share of older commands a sample later."""
        late, rest = self.counted, ca.fmax(b.net, 0)
        forces = [wheel_to_force(*self.wheels, self.torque), *self.forces]
        if late.varying:
            pieces = late.varying.entering
            ends = [self._followed(pieces, forces, axis, b, k)[2] for k in (0, 1)]
            return ca.vertcat(*ends) - rest
        assert late.tail is not None
        sure, mixed = late.tail.entering
        n, rows = late.commands, []
        old = forces[n][axis]
        newer = forces[n - 1][axis] if n else old
        for k, way in enumerate((1, -1)):
            joins = sure * push([old], b, way) + mixed * push([old, newer], b, way)
            stays = late.tail.decay * self.p["guard_tail"][2 * axis + k]
            rows.append(stays + b.period * (joins - (sure + mixed) * rest))
        return ca.vertcat(*rows)

    @property
    def _both(self) -> Bounds:
        first, second = (b for _, b, _ in self.axes)
        names = ("u1", "M_min", "M_max", "dbar", "nbar", "brake", "f_min", "f_speed")
        pairs = {n: ca.vertcat(getattr(first, n), getattr(second, n)) for n in names}
        return Bounds(period=first.period, alpha=first.alpha, **pairs)

    @cached_property
    def _motion(self) -> LateMotion:
        since = self.setup.guard.since_last(self.setup.scenario.clock)
        new = wheel_to_force(*self.wheels, self.torque)
        return LateMotion(since, self.forces, new)

    def least_pushes(self) -> Iterator[ca.SX]:
        """The monitor's figure of each axis, once all that it counts was sent."""
        if "guard_started" in self.p:
            yield from super().least_pushes()
            return
        motion = self._motion
        for axis, (y, b, _) in enumerate(self.axes):
            least = motion.least_push(axis, y, self.p["guard_v"][axis], b)
            begun = self.p["guard_samples"] >= 2 + ceil(self.counted.most)
            yield ca.if_else(begun, self._kept_as_named(least), 0)


def _periods(time: float) -> float:
    """Periods of a stated time, no fewer as doubles compute it."""
    count = time / PERIOD
    return count if count * PERIOD >= time else nextafter(count, inf)


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
def assembled(mutation: Mutation, kind: str, stated: Mapping[str, float]) -> Statement:
    """the torques of the whole guard are those of the map, linear-first or rotation-first, on both
    axes' clips and safe points, each axis with its own bounds and what is counted of the commands
    under way: piece after piece, what either of two commands may do, and what is kept of older
    ones, which is updated so; feasible = 1 only where both axes' flags are, their brakes together
    are within reach and the drives are no later, slower, sooner or more varied than is counted;
    each d_least is that of the monitor for late motion; without jitter and with one of half a
    period, the lag constant and varying by a quarter.

    The exported guard is composed of the parts that the entries about late velocities, jitter and
    lags are about.

    Given: any parameters with r, l, T, alpha, M_min, M_max, lag > 0, spread < 1; any force that is
    asked for; velocities are means over a period, a delay of half of one, a lag of 0.4 of it.
    """
    return exported(mutation, kind, LateAssembled(guard, setup(kind, 0, True, **stated)))


LAG, PART = {"actuator.lag": 0.4 * PERIOD}, {"actuator.delay": 0.5 * PERIOD}


@claim(
    "guard.assembled.alone",

    premises="guard.axes wheels.linear-first",
    each={
        "lag": {"stated": LAG}, "varying-lag": {"stated": LAG | {"actuator.lag_spread": 0.25}},
        "delay": {"stated": PART}, "jitter": {"stated": JITTER},
        "window": {"stated": {"sensor.velocity_window": PERIOD}},
    },
)  # fmt: skip
def alone(mutation: Mutation, stated: Mapping[str, float]) -> Statement:
    """nothing is late but one of: a lag of 0.4 of a period; one that varies by a quarter; a delay
    of half a period; a jitter of that; velocities, which are means over a period. The torques of
    the whole guard are those of linear-first on both axes' clips and safe points, with what is
    counted of the commands under way and, behind a lag, of older ones, the new one joining them as
    the wheels were given it; feasible = 1 only where both axes' flags are, their brakes together
    are within reach and the drives are no later, slower or more varied than is counted; each
    d_least is the monitor's, behind a constant lag or delay for the torque that is remembered as
    applied, else for late motion.

    Each way to be late, by itself, is counted as it is together with the others.

    Given: any parameters with r, l, T, alpha, M_min, M_max > 0, and lag, 1 - spread > 0 where there
    is one; any force that is asked for.
    """
    return exported(
        mutation, "linear-first", LateAssembled(guard, setup("linear-first", 0, True, **stated))
    )


@claim(
    "guard.assembled.controller{late}",

    over=(
        {"late": "", "more": "", "each": EXPORTED,
         "which": "without delay and behind one of two periods"},
        {"late": "-late", "more": ", lag, 1 - spread > 0, 0 < exp(-h/lag) < 1",
         "each": EXPORTED_LATE,
         "which": "late in the ways of guard.assembled.late"},
    ),
)  # fmt: skip
def controller(
    mutation: Mutation, kind: str, delay: int = 0, stated: Mapping[str, float] | None = None
) -> Statement:
    """torques, flag, d_least and the guard's memory one sample later are, in the whole controller,
    those of the whole guard on the force that the law asks for: with either map, {which}.

    What is proved of the exported guard holds for it inside of the controller.

    Given: any parameters with r, l, T, alpha, M_min, M_max > 0{more}; any measurements, targets and
    state.
    """
    loop, kind_of = (
        setup(kind, delay, True, **(stated or {})),
        LateAssembled if stated else Assembled,
    )
    whole, alone = (kind_of(make, loop) for make in (asking_controller, guard))
    put = [whole.asked if name == "force" else whole.p[name] for name in alone.p]
    told = "feasible", "d_least"
    theirs, ours = (
        ca.vertcat(
            *(e.later[name] for name in alone.later), *(e.told[name] for name in told), e.torque
        )
        for e in (whole, alone)
    )
    ours = ca.substitute(ours, ca.vertcat(*alone.p.values()), ca.vertcat(*put))
    free = symbols("e") if stated else Symbols()
    share = {name: ca.exp(-whole.p["clock.plant"] / whole.p["actuator.lag"]) for name in free}
    below = (item for e in free.values() for item in (e > 0, e < 1))
    given, cuts = (whole.signs, *below), {**whole.cuts, **share}
    return Statement(whole | free, every(mutation * theirs, ours), given, cuts)
