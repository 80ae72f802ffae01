"""The exported guard: the parts of its graphs, and its sums over commands.

Sums and pushes are calculated here piece by piece, as in the entries about pieces
(guard.late.piece, guard.late.tail, guard.varying.*).  The length of a piece, and its weight, are
numbers of the scenario.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import accumulate
from math import ceil, inf, nextafter

from casadi import SX, exp, fmax, horzcat, if_else, substitute, vertcat, vertsplit

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
from wmr_ctrl.control.guard.guard import MAPS, Bounds, clipped, feasible
from wmr_ctrl.control.guard.lateness import Piece
from wmr_ctrl.control.guard.monitor import LateMotion, least_push
from wmr_ctrl.control.guard.varying import Passage
from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.world.model.dynamics import force_to_wheel, wheel_to_force
from wmr_ctrl.world.model.system import System
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.claim import Mutation
from wmr_proofs.statement import Cuts, Named, Relations, Statement, every, positive

from .common import PRESET, named_ports, ports_of, scalars

PERIOD = 0.01


def setup(kind: str, delay: int, **more: object) -> Setup:
    """A loop with this map onto the wheels, behind a delay of so many periods."""
    stated: dict[str, object] = {
        "guard.enabled": True, "guard.map": kind, "clock.control": PERIOD,
        "actuator.delay": PERIOD * delay, **more,
    }  # fmt: skip
    return settle(load_scenario(PRESET, stated), "pid")


class Assembled(Named):
    """An exported graph, and the numbers of its two axes in the form of the claims' axes.

    ``p``: inputs, state and parameters by name.  ``told``: published values besides the torques.
    ``asked``: the requested force.  ``wheels``: radius and half track.  ``phi``: the wheels' reach.
    ``sent``: remembered torques, the last one first; ``forces``: those of these torques.
    ``counted``: weights of sent commands, equal for both axes.
    """

    def __init__(self, assemble: Callable[[Setup], System], loop: Setup) -> None:
        self.setup, self.system = loop, assemble(loop)
        ports = ports_of(self.system)
        self.symbols = scalars(ports)
        self.p = p = named_ports(*ports)
        self.told = {output.signal.name: output.expr for output in self.system.diagnostics}
        self.torque = vertcat(*(output.expr for output in self.system.outputs))
        self.asked = p["force"] if "force" in p else self.told["force"]
        self.wheels = p["robot.r"], p["robot.l"]
        self.phi = 2 * p["actuator.tau_max"] / self.wheels[0]
        kept = [name for name in p if name.startswith("tau_sent")]
        self.sent = [p[f"tau_sent{age}"] for age in range(1, len(kept) + 1)]
        self.forces = [wheel_to_force(*self.wheels, tau) for tau in self.sent]
        self.counted, second = loop.guard.lateness(loop.scenario.clock)
        assert self.counted == second

    @cached_property
    def axes(self) -> tuple[tuple[SX, Bounds, InFlight | None], ...]:
        """Measured velocity, bounds and commands in transit of each axis.

        u1 is a limit less (1 + n) 2^-44 of the larger of both directions', n the commands and the
        periods of the lag.
        """
        names = ("M_min", "M_max", "dbar", "nbar", "brake", "f_min", "f_speed")
        p, T, late = self.p, self.p["clock.control"], self.counted
        times = {"delay": late.most, "jitter": late.jitter, "mixed": late.mixed}
        lasting = {name: T * time for name, time in times.items() if time}
        kept = (1 + late.commands + ceil(late.lag)) * 2.0**-44
        sums = self._felt if late.varying else self._summed
        found: list[tuple[SX, Bounds, InFlight | None]] = []
        for axis, y in enumerate((p["v1"], p["omega"])):
            numbers = {name: p[f"guard.{name}"][axis] for name in names}
            u1, back = self._limits(axis, kept)
            b = Bounds(u1=u1, back=back, period=T, alpha=p["guard.alpha"], **numbers, **lasting)
            found.append((y, b, sums(axis, b) if late.commands or late.lag else None))
        return tuple(found)

    def _limits(self, axis: int, kept: float) -> tuple[SX, SX | None]:
        """Limit forwards and backwards, None if one is for both, less a share of the larger one."""
        if "limits.v_max" not in self.p:
            return self.p["limits.v_u1"][axis] * (1 - kept), None
        ahead, back = self.p["limits.v_max"][axis], -self.p["limits.v_min"][axis]
        less = kept * fmax(ahead, back)
        return ahead - less, back - less

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
        either = [horzcat(*(forces[j - 1] for j in which)) for which, _ in pieces]
        return in_flight(list(zip(either, (time for _, time in pieces), strict=True)), axis, b)

    def _older(self, axis: int, b: Bounds) -> list[SX]:
        """Remaining share of older commands, ahead and back."""
        tail = self.counted.tail
        if tail is None:
            return [SX(0), SX(0)]
        kept, steady = self.p["guard_tail"], tail.steady * b.period * fmax(b.net, 0)
        return [(kept[2 * axis + k] + steady) / b.M_min for k in (0, 1)]

    def _felt(self, axis: int, b: Bounds) -> InFlight:
        late, T = self.counted, b.period
        varying, ways = late.varying, []
        assert varying is not None
        for k, way in enumerate((1, -1)):
            means, rests, z = self._followed(varying.pieces, self.forces, axis, b, k)
            left = T * varying.longest * z
            after, again = z, SX(0)
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
        self, pieces: Sequence[Passage], forces: Sequence[SX], axis: int, b: Bounds, k: int
    ) -> tuple[SX, SX, SX]:
        """Integrals of Z, for mean and rest, and its end value; ``forces``: the latest first."""
        z = self.p["guard_tail"][2 * axis + k] + fmax(b.net, 0)
        mean = rest = SX(0)
        for piece in pieces:
            p = push([forces[j - 1][axis] for j in piece.which], b, 1 - 2 * k)
            mean += b.period * integral(z, p, piece.mean)
            rest += b.period * integral(z, p, piece.rest)
            z = moved(z, p, piece.stays)
        return mean, rest, z

    @cached_property
    def later(self) -> Cuts:
        """The state one sample later, by name."""
        ends = accumulate((port.sym.numel() for port in self.system.state), initial=0)
        names = [port.signal.name for port in self.system.state]
        return dict(zip(names, vertsplit(self.system.update, [*ends]), strict=True))

    def consists(self, torque: SX) -> Statement:
        """Goals: the outputs are these torques, both axes' flags, the memory and the monitor's
        figure.
        """
        return Statement(self, tuple(self._parts(torque)), self.signs, self.cuts)

    def _parts(self, torque: SX) -> Iterator[Relations]:
        bounds = [b for _, b, _ in self.axes]
        flags = [feasible(b) for b in bounds]
        flags.append(bounds[0].braking + bounds[1].braking / self.wheels[1] <= self.phi)
        flags += self.slow_drives()
        yield from (flag >= self.told["feasible"] for flag in flags)
        yield from every(self.torque, torque)
        for age, now in enumerate((self.torque, *self.sent[:-1])[: len(self.sent)], 1):
            yield from every(self.later[f"tau_sent{age}"], now)
        yield from self.kept()
        yield from every(self.later["guard_v"], vertcat(*(y for y, _, _ in self.axes)))
        for axis, known in enumerate(self.least_pushes()):
            yield self.told["d_least"][axis] == known

    def slow_drives(self) -> list[SX]:
        """Conditions that the drives are no slower, earlier or more variable than assumed."""
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
            growth = exp(step / (lag * (1 - spread))) - 1
            met.append(step >= _periods(fast) * T * growth)
        return met

    def kept(self) -> Iterator[Relations]:
        """Memory in addition to commands in transit: the next torque, or older commands behind a
        lag.
        """
        if not self.counted.lag:
            whole = all(time == 1 for _, time in self.counted.mean)
            if whole and not self.counted.jitter:
                yield from every(self.later["tau_applied"], (self.torque, *self.sent)[-1])
            return
        later = [self._joined(axis, b) for axis, (_, b, _) in enumerate(self.axes)]
        yield from every(self.later["guard_tail"], vertcat(*later))
        if "guard_monitor_tail" in self.later:
            told = self._kept_as_named(self._motion.following(self._both))
            yield from every(self.later["guard_monitor_tail"], told)

    def _kept_as_named(self, expr: SX) -> SX:
        """An expression of the monitor's with the state of the exported graph."""
        kept = self._motion.tails.state
        return substitute(expr, kept[0].sym, self.p["guard_monitor_tail"]) if kept else expr

    def _joined(self, axis: int, b: Bounds) -> SX:
        """The share of older commands a sample later."""
        late, rest = self.counted, fmax(b.net, 0)
        forces = [wheel_to_force(*self.wheels, self.torque), *self.forces]
        if late.varying:
            pieces = late.varying.entering
            return vertcat(*[self._followed(pieces, forces, axis, b, k)[2] for k in (0, 1)]) - rest
        assert late.tail is not None
        sure, mixed = late.tail.entering
        n, rows = late.commands, []
        old = forces[n][axis]
        newer = forces[n - 1][axis] if n else old
        for k, way in enumerate((1, -1)):
            joins = sure * push([old], b, way) + mixed * push([old, newer], b, way)
            stays = late.tail.decay * self.p["guard_tail"][2 * axis + k]
            rows.append(stays + b.period * (joins - (sure + mixed) * rest))
        return vertcat(*rows)

    @property
    def _both(self) -> Bounds:
        first, second = (b for _, b, _ in self.axes)
        names = ("u1", "M_min", "M_max", "dbar", "nbar", "brake", "f_min", "f_speed")
        pairs = {n: vertcat(getattr(first, n), getattr(second, n)) for n in names}
        return Bounds(period=first.period, alpha=first.alpha, **pairs)

    @cached_property
    def _motion(self) -> LateMotion:
        new = wheel_to_force(*self.wheels, self.torque)
        return LateMotion(self.setup.guard.since_last(self.setup.scenario.clock), self.forces, new)

    def least_pushes(self) -> Iterator[SX]:
        """The monitor's figure of each axis, once all commands that it uses were sent."""
        p, at_once = self.p, "guard_started" in self.p
        for axis, (y, b, _) in enumerate(self.axes):
            before = p["guard_v"][axis]
            if at_once:
                acted, begun = (
                    wheel_to_force(*self.wheels, p["tau_applied"]),
                    p["guard_started"] > 0,
                )
                least = least_push(y, before, acted[axis], b)
            else:
                least = self._kept_as_named(self._motion.least_push(axis, y, before, b))
                begun = p["guard_samples"] >= 2 + ceil(self.counted.most)
            yield if_else(begun, least, 0)

    @property
    def signs(self) -> Relations:
        """Signs of the divisors: all positive."""
        bounds = [b for _, b, _ in self.axes]
        masses = [mass for b in bounds for mass in (b.M_min, b.M_max)]
        numbers = positive(*self.wheels, bounds[0].period, bounds[0].alpha, *masses)
        if not self.counted.lag:
            return numbers
        return numbers, positive(
            self.p["actuator.lag"], 1 - self.p.get("actuator.lag_spread", SX(0))
        )

    @property
    def cuts(self) -> Cuts:
        """Symbols for the law's force, which is arbitrary."""
        asked = {} if "force" in self.p else {"asked thrust": 0, "asked moment": 1}
        return {name: self.asked[axis] for name, axis in asked.items()}


def exported(mutation: Mutation, kind: str, e: Assembled) -> Statement:
    """Goal: the torques are those of the map, applied to both axes' clips and safe points."""
    r, half = e.wheels
    force, safe = (
        vertcat(*(clipped(part, *axis) for part, axis in zip(wish, e.axes, strict=True)))
        for wish in (vertsplit(e.asked), (SX(0), SX(0)))
    )
    return e.consists(mutation * force_to_wheel(r, half, MAPS[kind](force, e.phi, half, safe)))


def _periods(time: float) -> float:
    """A stated time in periods, rounded so that it is not too small."""
    count = time / PERIOD
    return count if count * PERIOD >= time else nextafter(count, inf)
