"""Governor whose limits change while it drives, and that stops before what is in the way.

Each step may be told limits of both axes and directions, and the free way ahead, behind, to the
left and to the right.

**Limits.** With V the limit in force and v_bar the bound of the speed where the command takes over,

    hi = (V - d + min(k1 (V - v_bar), k2 (V - v_bar)))/K_max,       at least 0,
    k1 = 1/(exp(H/tau_min) - 1),   k2 = 1/(exp(h/tau_max) - 1),

with h the least time for which a command acts: the base is inside as soon as zeros would bring it
there (`filter.limits.enters`).

**Ways.** A command passes where its stop ends within the free way (`ways`). Where none does, (0, 0)
is sent: so is it for the other axis, whose command would open the brake. A base that the filter
stopped leaves by a command away from what is near, with which it cannot creep back: if its distance
certifies that; or if the command before was away, too; or if it was asked for from rest so long
that the way gained in that time exceeds what one release rolls.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property, reduce
from itertools import chain

import casadi as ca

from wmr_ctrl.core.signals import LARGEST, Signal
from wmr_ctrl.world.model.system import Port, port
from wmr_ctrl.world.scenario import Scenario

from .channels import (
    AXES,
    LIMIT_REFUSED,
    NEAR_BY,
    NO_DISTANCE,
    ROUNDING,
    SLOWING,
    WAYS,
    ends_of,
    within,
)
from .governor import NEAR, FirstOrder, Schedule, largest
from .governor_step import Governor, Sides
from .ways import Reached, Stop, ToldBound

LIMITS = Signal("limits", "m/s, rad/s", "limits in force: v_min, v_max, omega_min, omega_max", 4)
FREE = Signal("free", "m, rad", "free way ahead and behind, left and right; inf: no limit", 4)
FREE_AGE = Signal("free_age", "s", "age of the free ways; negative: none is told")
FREE_KNOWN = Signal("free_known", "m, rad", "least free ways since they were told", 4)
WAITED = Signal("waited", "m/s, rad/s", "refused pull away from each side, summed over steps", 4)
RESTED = Signal("rested", "1", "commands of (0, 0) in a row, in time")
LEAST_PULL = 1e-9
"""Least speed away [m/s, rad/s] that counts as one."""
PENDING = 1e-12
"""Sum of a request that was refused before the base stood."""
LEAST_PERIOD = 1e-9
"""Least time for which a command is taken to act [s], so that k2 is finite."""


class StoppingGovernor(Governor):
    """Graph of a governor that is told limits, free ways, or that its base brakes at rest."""

    def __init__(self, scenario: Scenario) -> None:
        """Create the ports; ScenarioError if the times span too many samples."""
        super().__init__(scenario)
        settings, p, last = scenario.filter, self.p, self.oldest
        self.distances, self.rest = settings.free_error is not None, None
        if settings.rest is not None:
            self.rest = p.take("filter.rest")
        tau = ends_of(p, "tau")
        self.channels = [replace(c, sides=(c.sides[0], c.sides[-1])) for c in self.channels]
        starts = [c.largest[place] for place in (0, -1) for c in self.channels]
        self.most_before = [port(_most(age), starts) for age in range(1, last + 1)]
        self.held_before = (
            [port(_held(age)) for age in range(1, last + 1)] if self.rest is not None else []
        )
        self.rested = [port(RESTED)] if self.held_before else []
        ends = [end for pair in scenario.limits.sides for end in pair]
        self.limits_told = port(LIMITS, ends)
        self.free, self.free_age = port(FREE, [LARGEST] * 4), port(FREE_AGE, -1.0)
        self.free_known, self.waited = port(FREE_KNOWN, [-1.0] * 4), port(WAITED)
        still = [_nothing(item.sym) for item in self.before] if self.rest is not None else []
        self.told = [
            [
                ToldBound(
                    plan, c.sides[place], tau[i], self.T,
                    most=[ca.SX(0), *(item.sym[2 * place + i] for item in self.most_before)],
                    still=[ca.SX(0), *still] if still else (),
                    punctual=self.punctual,
                )
                for i, (c, plan) in enumerate(zip(self.channels, self.plans, strict=True))
            ]
            for place in AXES
        ]  # fmt: skip
        self.motions = [[*side] for side in self.told]
        self.stops = [self._stop(i, tau[i]) for i in AXES]
        numbers = [*([self.rest] if self.rest is not None else [])]
        if self.distances:
            numbers += [p.take(f"filter.{name}") for name in ("free_error", "free_age", "nearing")]
        sizes = [ca.logic_and(item >= 0, item <= LARGEST) for item in numbers]
        self.sound = reduce(ca.logic_and, sizes, self.sound)

    @property
    def remembered(self) -> int:
        """Number of commands that the state holds, those while a distance was measured included."""
        least = super().remembered
        settings, T = self.scenario.filter, self.scenario.clock.control
        if settings.free_error is None:
            return least
        return max(least, *(replace(p, age=settings.free_age / T).oldest for p in self.plans))

    def _stop(self, axis: int, tau: tuple[ca.SX, ca.SX]) -> Stop:
        plan, d = self.plans[axis], self.channels[axis].bounds.dbar
        spread = plan.delay[1] - plan.delay[0]
        nears = self.distances and axis == 0
        nearing = self.p.take("filter.nearing") if nears else ca.SX(0)
        acts, last = (plan.longest - spread) * self.T, plan.delay[1] * self.T
        return Stop(tau, d, self.rest, acts, last, nearing)

    @cached_property
    def in_force(self) -> Sides:
        """Limit of each side: at least the push, at most the scenario's; the push if not told."""
        if not self.scenario.filter.changing:
            return [[b.V for b in self._bounds(place)] for place in AXES]
        told, sides = self.limits_told.sym, []
        for place, way in enumerate(WAYS):
            limits = []
            for i, b in enumerate(self._bounds(place)):
                limit, widest = way * told[2 * i + 1 - place], largest([c.V for c in self._pair(i)])
                less = ca.fmax(b.dbar, ca.fmin(limit - ROUNDING * widest, b.V))
                limits.append(ca.if_else(_is_number(limit), less, b.dbar))
            sides.append(limits)
        return sides

    def _bounds(self, place: int) -> list[FirstOrder]:
        return [channel.sides[place] for channel in self.channels]

    def _pair(self, axis: int) -> tuple[FirstOrder, ...]:
        return self.channels[axis].sides

    @cached_property
    def now(self) -> Sides:
        """Bounds of the present speed, by what acts now also."""
        return [
            [ca.fmin(v, m.cap_now) for v, m in zip(side, motions, strict=True)]
            for side, motions in zip(super().now, self.told, strict=True)
        ]

    @cached_property
    def takeover(self) -> Sides:
        """v_bar: bounds of the speed at any time at which the next command may take effect."""
        return [
            [
                ca.if_else(self.trusted, m.takeover(side[i], self._targets(way, i)), m.bounds.V)
                for i, m in enumerate(motions)
            ]
            for way, side, motions in zip(WAYS, self.start, self.told, strict=True)
        ]

    @cached_property
    def free_now(self) -> Sides:
        """Free way of each side: told, or what was told before less the way since then."""
        error, nearing = self.p.take("filter.free_error"), self.p.take("filter.nearing")
        age, sides = self.free_age.sym, []
        for place, motions in enumerate(self.told):
            ways = []
            for i, motion in enumerate(motions):
                number, V = place + 2 * i, motion.bounds.V
                most = largest([ca.SX(0), *motion.most[1:]])
                gone = (ca.if_else(self.trusted, most, V) + (0 if i else nearing)) * age
                far = self._far(place, i)
                told = ca.fmin(self.free.sym[number], far) - (0 if i else error)
                known = ca.if_else(self.came, self.free_known.sym[number], -1)
                fresh = ca.logic_and(self.is_fresh, _is_number(self.free.sym[number]))
                ways.append(ca.if_else(fresh, told - gone - ROUNDING * far, known))
            sides.append(ways)
        return sides

    @cached_property
    def is_fresh(self) -> ca.SX:
        """1 where the free ways are told, and not too old."""
        half = 0.5 * self.p.take("filter.free_age")
        return within(self.free_age.sym - half, half + NEAR * self.T)

    def _far(self, place: int, axis: int) -> ca.SX:
        """Way from which on a free way limits no command."""
        stop, b = self.stops[axis], self.channels[axis].sides[place]
        times = stop.time + stop.fading + self.p.take("filter.free_age")
        return 2 * (1 + b.kappa) * (b.V + stop.nearing) * (times + self.T) + stop.creep

    @cached_property
    def reached(self) -> list[list[list[Reached]]]:
        """Ways and speeds of each side where the next command may take over."""
        sides = []
        for way, side, motions in zip(WAYS, self.start, self.told, strict=True):
            sides.append([
                [self._sure(at, m) for at in m.takeovers(side[i], self._targets(way, i))]
                for i, m in enumerate(motions)
            ])  # fmt: skip
        return sides

    def _sure(self, at: Reached, motion: ToldBound) -> Reached:
        """What is reached, the most where the times of commands cannot be trusted."""
        V, last = motion.bounds.V, motion.schedule.delay[1] * self.T
        return Reached(
            at.instant,
            ca.if_else(self.trusted, at.way, V * last),
            ca.if_else(self.trusted, at.speed, V),
        )

    @cached_property
    def stopping(self) -> Sides:
        """Largest commands by the free ways; below 0 where no stop ends in time."""
        sides = []
        for place in AXES:
            limits = []
            for i, (stop, b) in enumerate(zip(self.stops, self._bounds(place), strict=True)):
                free = self.free_now[place][i] - self.scenario.filter.leave * stop.roll
                limits.append((stop.steady(free, self.reached[place][i]) - b.dbar) / b.K_max)
            sides.append(limits)
        return sides

    @cached_property
    def limits(self) -> Sides:
        """Largest safe commands of all channels, forwards and backwards."""
        sides = []
        for place, motions in enumerate(self.told):
            limits = []
            for i, motion in enumerate(motions):
                most = self._admitted(place, i, motion)
                limits.append(ca.fmin(most, self.stopping[place][i]) if self.distances else most)
            sides.append([ca.fmax(0, limit) for limit in limits])
        return sides

    def _admitted(self, place: int, axis: int, motion: ToldBound) -> ca.SX:
        """Largest command by the limit in force."""
        V, v_bar, b = self.in_force[place][axis], self.takeover[place][axis], motion.bounds
        plan = motion.schedule
        acts = ca.fmax(plan.shortest * self.T, LEAST_PERIOD)
        above = 1 / ca.expm1(acts / motion.tau[1])
        room = V - v_bar
        command = (V - b.dbar + ca.fmin(b.kappa * room, above * room)) / b.K_max
        return ca.if_else(b.dbar < V, command, 0)

    @cached_property
    def offered(self) -> ca.SX:
        """The command (2,) before it is known whether the brake may open for it."""
        return self.within_limits

    @cached_property
    def away(self) -> Sides:
        """Steady speeds towards each side, at most; 1 if the command drives away from it."""
        sides = []
        for place, way in enumerate(WAYS):
            bounds = self._bounds(place)
            u = [way * self.offered[i] for i in AXES]
            sides.append([b.K_min * u[i] + b.dbar for i, b in enumerate(bounds)])
        return sides

    @cached_property
    def leaves(self) -> Sides:
        """1 for each side from which the command drives away, whatever pushes."""
        return [
            [ca.logic_and(way * self.offered[i] < 0, self.away[place][i] <= 0) for i in AXES]
            for place, way in enumerate(WAYS)
        ]

    @cached_property
    def pull(self) -> Sides:
        """Least speed away from each side that the command comes to in the long run."""
        sides = []
        for place in AXES:
            pulls = []
            for i, b in enumerate(self._bounds(place)):
                steady = (self.in_force[1 - place][i] - b.dbar) / b.K_max
                pulls.append(b.K_min * ca.fmin(ca.fabs(self.offered[i]), steady) - b.dbar)
            sides.append(pulls)
        return sides

    @cached_property
    def open(self) -> Sides:
        """1 for each side that the command may use, or from which it may drive away."""
        sides = []
        for place, way in enumerate(WAYS):
            opens = []
            for i, stop in enumerate(self.stops):
                v_bar, behind = self.takeover[place][i], self.reached[place][i][-1].way
                need = stop.retreat(behind, v_bar, self.away[place][i])
                enough = [self.free_now[place][i] >= need]
                if not self.scenario.filter.nearing:
                    enough += [way * self.before[0].sym[i] < 0, stop.push == 0]
                    enough += [self._is_ripe(place, i)] if self.rest is not None else []
                leaves = self.leaves[place][i]
                if self.rest is not None:  # else zeros would lead no less far than it does
                    leaves = ca.logic_and(leaves, v_bar <= 0)
                passes = ca.logic_and(leaves, reduce(ca.logic_or, enough))
                certain = self.stopping[place][i] >= 0
                if self.rest is not None and not self.scenario.filter.nearing:
                    certain = ca.logic_and(certain, self._lasts(place, i))
                opens.append(ca.logic_or(certain, passes))
            sides.append(opens)
        return sides

    def _lasts(self, place: int, axis: int) -> ca.SX:
        """0 for a request away that was refused, and may be so again before it has led away.

        Distances that are off now and then would let single commands pass, after each of which
        rest is no longer known.
        """
        way, push = WAYS[place], self.channels[axis].bounds.dbar
        request = [self.leaves[place][axis], self.waited.sym[place + 2 * axis] > 0]
        fresh = reduce(ca.logic_and, (*request, way * self.before[0].sym[axis] >= 0))
        free = self._stays_free(place, axis, push, self._lasting(place, axis))
        return ca.logic_or(ca.logic_not(fresh), free)

    def _holding(self, place: int, axis: int) -> ca.SX:
        """n_hold: commands away after which a release ends no nearer than where it began."""
        plan, pull = self.plans[axis], self.pull[place][axis]
        return plan.losses + whole_steps(plan, self.T, self.stops[axis].hold(pull))

    def _lasting(self, place: int, axis: int) -> ca.SX:
        """Longest time [s] for which n_hold commands and the one before may act."""
        plan = self.plans[axis]
        return (self._holding(place, axis) * (1 + plan.jitter) + plan.longest) * self.T

    def _is_ripe(self, place: int, axis: int) -> ca.SX:
        """1 where a command straight away was asked for from rest long enough."""
        pull, time = self.pull[place][axis], self._lasting(place, axis)
        waited = self.waited.sym[place + 2 * axis] >= self._holding(place, axis) * pull
        straight = self.offered[1 - axis] == 0
        V, fading = self.in_force[1 - place][axis], self.stops[axis].fading
        goes_on = [self._stays_free(1 - place, axis, V, time + fading)]
        across = 1 - axis
        push = self.channels[across].bounds.dbar
        goes_on += [self._stays_free(side, across, push, time) for side in AXES]
        return reduce(ca.logic_and, (pull > LEAST_PULL, waited, straight, *goes_on))

    def _stays_free(self, place: int, axis: int, speed: ca.SX, time: ca.SX) -> ca.SX:
        """1 where a side stays open while its speed is at most this for a time [s].

        Ways that are told later may be less by twice their error and the way of their age.
        """
        stop, aged = self.stops[axis], self.p.take("filter.free_age")
        told = speed * aged + (0 if axis else 2 * self.p.take("filter.free_error"))
        kept = self.scenario.filter.leave * stop.roll
        return self.free_now[place][axis] - kept >= speed * time + stop.creep + told

    @cached_property
    def opens(self) -> ca.SX:
        """1 where no side forbids the command."""
        return reduce(ca.logic_and, (item for side in self.open for item in side))

    @cached_property
    def safe(self) -> ca.SX:
        """The safe command (2,) for sound parameters."""
        return ca.if_else(self.opens, self.offered, 0) if self.distances else self.offered

    @cached_property
    def held(self) -> ca.SX:
        """1 where the base stands by the time the command acts, and (0, 0) is sent."""
        plan = max(self.plans, key=lambda plan: plan.delay[1] - plan.delay[0])
        time = ca.SX(0) if self.rest is None else self.rest
        time += plan.losses * (1 + plan.jitter) * self.T
        enough = self._in_row >= whole_steps(plan, self.T, time, NEAR)
        return ca.logic_and(_nothing(self.safe), enough)

    @property
    def _in_row(self) -> ca.SX:
        return ca.if_else(self.came, self.rested[0].sym, 0)

    @cached_property
    def most(self) -> Sides:
        """Bound of the speed while the command just sent acts."""
        sides = []
        for place, way in enumerate(WAYS):
            most = []
            for i, v_bar in enumerate(self.takeover[place]):
                target = self._targets(way, i, self.safe)[0]
                bound = ca.fmin(ca.fmax(self.in_force[place][i], v_bar), ca.fmax(v_bar, target))
                if self.rest is not None:
                    bound = ca.if_else(_nothing(self.safe), ca.fmax(bound, 0), bound)
                    bound = ca.if_else(self.held, 0, bound)
                most.append(bound)
            sides.append(most)
        return sides

    def _targets(self, way: int, number: int, newest: ca.SX | None = None) -> list[ca.SX]:
        """Steady speed to which each command may drive an axis: 0 while the base stands."""
        targets = super()._targets(way, number, newest)
        if self.rest is None:
            return targets
        held = [ca.SX(0) if newest is None else self.held, *(h.sym for h in self.held_before)]
        return [ca.if_else(h, 0, target) for h, target in zip(held, targets, strict=True)]

    @cached_property
    def onward(self) -> list[list[ToldBound]]:
        """`told` with the command just sent."""
        still = _nothing(self.safe)
        return [
            [
                replace(
                    m,
                    most=[self.most[place][i], *m.most[1:]],
                    still=[still, *m.still[1:]] if m.still else (),
                )
                for i, m in enumerate(motions)
            ]
            for place, motions in enumerate(self.told)
        ]

    @cached_property
    def following(self) -> Sides:
        """Bounds of the speed at the next sample, after the safe command."""
        return [
            [m.following(side[i], self._targets(way, i, self.safe)) for i, m in enumerate(motions)]
            for way, side, motions in zip(WAYS, self.start, self.onward, strict=True)
        ]

    @cached_property
    def free_following(self) -> list[ca.SX]:
        """Free ways at the next sample."""
        free = []
        for i in AXES:
            for place, way in enumerate(WAYS):
                motion, start = self.onward[place][i], self.start[place][i]
                latest = (1 + motion.schedule.jitter) * self.T
                gone = motion.until_next(start, self._targets(way, i, self.safe))
                gone = ca.if_else(self.trusted, gone, motion.bounds.V * latest)
                nearer = self.stops[i].nearing * latest
                free.append(self.free_now[place][i] - gone - nearer)
        return free

    @cached_property
    def waiting(self) -> list[ca.SX]:
        """Refused pull away from each side, summed: it ends with the request, or once it passes."""
        sums = []
        stands = self.held_before[0].sym
        for i in AXES:
            for place, way in enumerate(WAYS):
                others = [
                    item for k, side in enumerate(self.open) for j, item in enumerate(side)
                    if (k, j) != (place, i)
                ]  # fmt: skip
                asked = self.leaves[place][i]
                counts = reduce(ca.logic_and, (stands, asked, *others))
                before, pull = self.waited.sym[place + 2 * i], self.pull[place][i]
                refused = ca.if_else(counts, before + ca.fmax(pull, 0), PENDING * asked)
                goes_on = ca.if_else(way * self.safe[i] < 0, before, 0)
                sums.append(ca.if_else(self.opens, goes_on, refused))
        return sums

    @property
    def inputs(self) -> tuple[Port, ...]:
        """What each step is told."""
        limits = (self.limits_told,) if self.scenario.filter.changing else ()
        free = (self.free, self.free_age) if self.distances else ()
        return (*super().inputs, *limits, *free)

    @property
    def flags(self) -> ca.SX:
        """Sum of the flags, for sound parameters."""
        flags = super().flags
        if self.scenario.filter.changing:
            pairs = zip(chain(*self.takeover), chain(*self.in_force), strict=True)
            faster = reduce(ca.logic_or, (v > V for v, V in pairs))
            numbers = reduce(ca.logic_and, (_is_number(self.limits_told.sym[k]) for k in range(4)))
            flags += ca.if_else(faster, SLOWING, 0) + ca.if_else(numbers, 0, LIMIT_REFUSED)
        if self.distances:
            flags += ca.if_else(self.opens, 0, NEAR_BY) + ca.if_else(self.is_fresh, 0, NO_DISTANCE)
        return flags

    @property
    def memory(self) -> tuple[tuple[Port, ...], list[ca.SX]]:
        """State, the governor's first, and its next values."""
        state, update = super().memory
        own: list[tuple[Sequence[Port], list[ca.SX], float]] = [
            (self.most_before, [*chain(*self.most), *_shifted(self.most_before)], LARGEST)
        ]
        if self.rest is not None:
            still = ca.if_else(_nothing(self.safe), self._in_row + 1, 0)
            own.append((self.held_before, [self.held, *_shifted(self.held_before)], 0))
            own.append((self.rested, [still], 0))
        if self.distances:
            own.append(([self.free_known], self.free_following, -1))
        if self.distances and self.rest is not None:
            own.append(([self.waited], self.waiting, 0))
        ports = (item for items, _, _ in own for item in items)
        values = (ca.if_else(self.sound, ca.vertcat(*new), other) for _, new, other in own)
        return (*state, *ports), [*update, *values]


def _shifted(before: Sequence[Port]) -> list[ca.SX]:
    return [item.sym for item in before[:-1]]


def whole_steps(plan: Schedule, T: ca.SX, time: ca.SX, more: float = -NEAR) -> ca.SX:
    """Number of commands that surely act for at least this time [s], and ``more`` of a period.

    A brake ends a motion at once, so that rest needs more than the time after which it closes.
    """
    spread = plan.delay[1] - plan.delay[0]
    return ca.ceil((time + spread * T) / ((1 - plan.jitter) * T) + more)


def _nothing(command: ca.SX) -> ca.SX:
    return ca.logic_and(command[0] == 0, command[1] == 0)


def _is_number(value: ca.SX) -> ca.SX:
    return ca.logic_or(value >= 0, value < 0)


def _most(age: int) -> Signal:
    said = f"bound of v, omega and of their negatives while the command of {age} samples ago acts"
    return Signal(f"v_most_{age}", "m/s, rad/s", said, 4)


def _held(age: int) -> Signal:
    return Signal(f"held_{age}", "1", f"1: the base stands while the command of {age} ago acts")
