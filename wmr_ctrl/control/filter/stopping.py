"""Governor whose limits may change while it drives, and that stops before obstacles.

Each step may receive limits of both axes and directions, and the free distance ahead, behind, to
the left and to the right.

**Limits.** With V the limit in force and v_bar the bound of the speed where the command takes over,

    hi = (V - d + min(k1 (V - v_bar), k2 (V - v_bar)))/K_max,       at least 0,
    k1 = 1/(exp(H/tau_min) - 1),   k2 = 1/(exp(h/tau_max) - 1),

with h the least time for which a command acts: the base is within the limit as soon as zeros would
bring it there (`filter.limits.enters`).

**Free distances.** A command passes if its stop ends within the free distance (`ways`).  If no
command does, (0, 0) is sent, on the other axis too, whose command would open the brake.  A base
that the filter stopped leaves by a command away from the obstacle that cannot let it creep back.
Such a command is sent in three cases: the free distance is large enough, the command before was
one, or it was requested from rest for so long that the distance gained exceeds the roll of one
release.
"""

from dataclasses import replace
from functools import cached_property, reduce
from itertools import chain

import casadi as ca

from wmr_ctrl.control.sides import limits_port
from wmr_ctrl.core.signals import LARGEST, Signal
from wmr_ctrl.world.model.system import Port, port
from wmr_ctrl.world.scenario import Scenario

from .channels import (
    AXES,
    NEAR_BY,
    NO_DISTANCE,
    SLOWING,
    WAYS,
    ends_of,
    is_nothing,
    told_limits,
    two_sided,
    unusable_limits,
)
from .governor import NEAR, FirstOrder, SpeedBound
from .governor_step import Governor
from .heard import Sides, Watching, each_side, whole_steps
from .ways import Reached, Stop, ToldBound, told_command

WAITED = Signal(
    "waited", "m/s, m/s, rad/s, rad/s", "refused pull away from each side, summed over steps", 4
)
TRACE = 1e-20
"""Commands [m/s, rad/s] up to this are 0: what a limit of 0 leaves of a curve opens no brake."""
LEAST_PULL = 1e-9
"""Least speed away [m/s, rad/s] that counts as one."""
PENDING = 1e-12
"""Sum of a request that was refused before the base stood."""
LEAST_PERIOD = 1e-9
"""Least time for which a command is taken to act [s], so that k2 is finite."""


class StoppingGovernor(Watching, Governor):
    """Graph of a governor that receives limits or free distances, or whose base brakes at rest."""

    def __init__(self, scenario: Scenario) -> None:
        """Create the ports; ScenarioError if the times span too many samples."""
        super().__init__(scenario)
        settings, p = scenario.filter, self.p
        self.distances = settings.free_error is not None
        self.rest = None if settings.rest is None else p.take("filter.rest")
        tau = ends_of(p, "tau")
        self.channels = two_sided(self.channels)
        self.limits_told = limits_port(scenario)
        self.waited = port(WAITED)
        before = [item.sym for item in self.before]
        self.told = each_side(lambda place, i: ToldBound(
            self.plans[i], self.channels[i].sides[place], tau[i], self.T,
            most=[ca.SX(0), *(item.sym[2 * place + i] for item in self.most_before)],
            still=self._still(i, before[0], *before), punctual=self.punctual,
        ))  # fmt: skip
        self.motions = [list[SpeedBound](side) for side in self.told]
        self.stops = [self._stop(i, tau[i]) for i in AXES]
        numbers = [*([self.rest] if self.rest is not None else [])]
        if self.distances:
            numbers += [p.take(f"filter.{name}") for name in ("free_error", "free_age", "nearing")]
        sizes = [ca.logic_and(item >= 0, item <= LARGEST) for item in numbers]
        self.sound = reduce(ca.logic_and, sizes, self.sound)

    @property
    def _alike(self) -> bool:
        """True if both parts of a command act at once: else one may open a brake for the other."""
        return self.plans[0].delay == self.plans[1].delay

    def _still(self, axis: int, *commands: ca.SX) -> list[ca.SX]:
        """1 for each command (2,) that may act as (0, 0), so that a brake may close.

        Dead bands or quanta within d may hide it.  Where the delays of v and omega differ, a brake
        may close for parts of two commands.  Empty without a brake.
        """
        if self.rest is None:
            return []
        parts = AXES if self._alike else (axis,)
        sizes = [(i, self.channels[i].bounds) for i in parts]
        return [
            reduce(ca.logic_and, (b.K_min * ca.fabs(u[i]) <= b.dbar for i, b in sizes))
            for u in commands
        ]

    def _stop(self, axis: int, tau: tuple[ca.SX, ca.SX]) -> Stop[ca.SX]:
        plan, d = self.plans[axis], self.channels[axis].bounds.dbar
        nears = self.distances and axis == 0
        nearing = self.p.take("filter.nearing") if nears else ca.SX(0)
        acts, last = plan.acting * self.T, plan.delay[1] * self.T
        return Stop(tau, d, self.rest, acts, last, nearing)

    @cached_property
    def in_force(self) -> Sides:
        """Limit of each side: at least the push, at most the scenario's; the push if not
        received.
        """
        if not self.scenario.filter.changing:
            return each_side(lambda place, i: self._bounds(place)[i].V)
        return told_limits(self.limits_told.sym, self.channels)

    def _bounds(self, place: int) -> list[FirstOrder]:
        return [channel.sides[place] for channel in self.channels]

    @cached_property
    def now(self) -> Sides:
        """Bounds of the present speed, also from the commands that act now."""
        own = super().now
        return each_side(lambda place, i: self.told[place][i].present(own[place][i]))

    @cached_property
    def takeover(self) -> Sides:
        """v_bar: bounds of the speed at any time at which the next command may take effect."""
        return each_side(self._takeover)

    def _takeover(self, place: int, axis: int) -> ca.SX:
        motion, targets = self.told[place][axis], self._targets(WAYS[place], axis)
        v_bar = motion.takeover(self.start[place][axis], targets)
        return ca.if_else(self.trusted, v_bar, motion.bounds.V)

    @property
    def believed(self) -> ca.SX:
        """1 if the bounds of the speed are valid."""
        return self.trusted

    def far(self, place: int, axis: int) -> ca.SX:
        """Free distance from which on no command is limited."""
        stop, b = self.stops[axis], self.channels[axis].sides[place]
        times = stop.time + stop.fading + self.p.take("filter.free_age")
        kept = (1 + self.scenario.filter.leave) * stop.creep
        kept += 0 if axis else 2 * self.p.take("filter.free_error")
        return 2 * (1 + b.kappa) * (b.V + stop.nearing) * (times + self.T) + kept

    @cached_property
    def reached(self) -> list[list[list[Reached[ca.SX]]]]:
        """Distances and speeds on each side when the next command may take over."""
        return each_side(self._reached)

    def _reached(self, place: int, axis: int) -> list[Reached[ca.SX]]:
        motion, targets = self.told[place][axis], self._targets(WAYS[place], axis)
        takeovers = motion.takeovers(self.start[place][axis], targets)
        return [self._sure(at, motion) for at in takeovers]

    def _sure(self, at: Reached[ca.SX], motion: ToldBound) -> Reached[ca.SX]:
        """`reached`, or the largest values if the commands' times cannot be trusted."""
        V, last = motion.bounds.V, motion.schedule.delay[1] * self.T
        return Reached(
            at.instant,
            ca.if_else(self.trusted, at.way, V * last),
            ca.if_else(self.trusted, at.speed, V),
        )

    @cached_property
    def stopping(self) -> Sides:
        """Largest commands by the free distances; below 0 if no stop ends in time."""
        return each_side(self._stopping)

    def _stopping(self, place: int, axis: int) -> ca.SX:
        stop, b = self.stops[axis], self._bounds(place)[axis]
        free = self.free_now[place][axis] - self.scenario.filter.leave * stop.roll
        return (stop.steady(free, self.reached[place][axis]) - b.dbar) / b.K_max

    @cached_property
    def limits(self) -> Sides:
        """Largest safe commands of all channels, forwards and backwards."""
        return each_side(lambda place, i: ca.fmax(0, self._admitted(place, i)))

    def _admitted(self, place: int, axis: int) -> ca.SX:
        """Largest command by the limit in force and by the free distance."""
        motion = self.told[place][axis]
        acts = ca.fmax(motion.schedule.shortest * self.T, LEAST_PERIOD)
        slowest, V = 1 / ca.expm1(acts / motion.tau[1]), self.in_force[place][axis]
        v_bar, b = self.takeover[place][axis], motion.bounds
        most = told_command(V, v_bar, b, slowest)
        if self.rest is not None:  # a brake may close while a command acts that counts as 0
            stood = told_command(V, ca.fmax(v_bar, 0), b, slowest)
            most = ca.if_else(b.K_min * stood < b.dbar, stood, most)
        return ca.fmin(most, self.stopping[place][axis]) if self.distances else most

    @cached_property
    def offered(self) -> ca.SX:
        """Command (2,) before it is known whether the brake may open for it."""
        sent = self.within_limits
        return ca.if_else(ca.fabs(sent) > TRACE, sent, 0)

    @cached_property
    def away(self) -> Sides:
        """Largest steady speed towards each side."""
        return each_side(self._away)

    def _away(self, place: int, axis: int) -> ca.SX:
        b = self._bounds(place)[axis]
        return b.K_min * (WAYS[place] * self.offered[axis]) + b.dbar

    @cached_property
    def leaves(self) -> Sides:
        """1 for each side that the command drives away from under any push."""
        return each_side(lambda place, i: ca.logic_and(
            WAYS[place] * self.offered[i] < 0, self.away[place][i] <= 0
        ))  # fmt: skip

    @cached_property
    def pull(self) -> Sides:
        """Least steady speed of the command away from each side."""
        return each_side(self._pull)

    def _pull(self, place: int, axis: int) -> ca.SX:
        b = self._bounds(place)[axis]
        steady = (self.in_force[1 - place][axis] - b.dbar) / b.K_max
        return b.K_min * ca.fmin(ca.fabs(self.offered[axis]), steady) - b.dbar

    @cached_property
    def open(self) -> Sides:
        """1 for each side that the command may use, or that it may drive away from."""
        return each_side(self._is_open)

    def _is_open(self, place: int, axis: int) -> ca.SX:
        stop, v_bar = self.stops[axis], self.takeover[place][axis]
        behind = self.reached[place][axis][-1].way
        enough = [self.free_now[place][axis] >= stop.retreat(behind, v_bar, self.away[place][axis])]
        if not self.scenario.filter.nearing:
            enough += [WAYS[place] * self.before[0].sym[axis] < 0, stop.push == 0]
            enough += [self._is_ripe(place, axis)] if self.rest is not None else []
        leaves = self.leaves[place][axis]
        if self.rest is not None:  # else zeros would lead no less far than it does
            leaves = ca.logic_and(leaves, v_bar <= 0)
        passes = ca.logic_and(leaves, reduce(ca.logic_or, enough))
        certain = self.stopping[place][axis] >= 0
        if self.rest is not None and not self.scenario.filter.nearing:
            certain = ca.logic_and(certain, self._lasts(place, axis))
        return ca.logic_or(certain, passes)

    def _lasts(self, place: int, axis: int) -> ca.SX:
        """0 for a request away that was refused, and may be refused again before it has led away.

        Distances with occasional errors would let single commands pass, and after each of them rest
        is no longer known.
        """
        way, push = WAYS[place], self.channels[axis].bounds.dbar
        request = [self.leaves[place][axis], self.waited.sym[place + 2 * axis] > 0]
        fresh = reduce(ca.logic_and, (*request, way * self.before[0].sym[axis] >= 0))
        free = self._stays_free(place, axis, push, self._lasting(place, axis))
        return ca.logic_or(ca.logic_not(fresh), free)

    def _holding(self, place: int, axis: int) -> ca.SX:
        """n_hold: number of commands away after which a release ends no nearer than the start."""
        plan, pull = self.plans[axis], self.pull[place][axis]
        return plan.losses + whole_steps(plan, self.T, self.stops[axis].hold(pull))

    def _lasting(self, place: int, axis: int) -> ca.SX:
        """Longest time [s] for which n_hold commands and the one before may act."""
        plan = self.plans[axis]
        return (self._holding(place, axis) * (1 + plan.jitter) + plan.longest) * self.T

    def _is_ripe(self, place: int, axis: int) -> ca.SX:
        """1 if a command straight away was requested from rest for long enough."""
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
        """1 if a side stays open while the speed towards it is at most ``speed`` for a time [s].

        Distances received later may be smaller by twice their error and by the distance driven in
        their age.
        """
        stop, aged = self.stops[axis], self.p.take("filter.free_age")
        told = speed * aged + (0 if axis else 2 * self.p.take("filter.free_error"))
        kept = self.scenario.filter.leave * stop.roll
        return self.free_whole[place][axis] - kept >= speed * time + stop.creep + told

    @cached_property
    def opens(self) -> ca.SX:
        """1 if no side forbids the command."""
        return reduce(ca.logic_and, (item for side in self.open for item in side))

    @cached_property
    def safe(self) -> ca.SX:
        """Safe command (2,) for sound parameters."""
        return ca.if_else(self.opens, self.offered, 0) if self.distances else self.offered

    @cached_property
    def held(self) -> ca.SX:
        """1 if the base stands by the time the command acts, and (0, 0) is sent."""
        plan = self.plans[0]
        rest = ca.SX(0) if self.rest is None else self.rest
        time = rest + plan.losses * (1 + plan.jitter) * self.T
        enough = self.in_row >= whole_steps(plan, self.T, time, NEAR)
        return ca.logic_and(is_nothing(self.safe), enough) if self._alike else ca.SX(0)

    @cached_property
    def most(self) -> Sides:
        """Bound of the speed while the command just sent acts."""
        return each_side(self._most)

    def _most(self, place: int, axis: int) -> ca.SX:
        v_bar, V = self.takeover[place][axis], self.in_force[place][axis]
        target, *_ = self._targets(WAYS[place], axis, self.safe)
        bound = ca.fmin(ca.fmax(V, v_bar), ca.fmax(v_bar, target))
        if self.rest is None:
            return bound
        bound = ca.if_else(self._still(axis, self.safe)[0], ca.fmax(bound, 0), bound)
        return ca.if_else(self.held, 0, bound)

    def _targets(self, way: int, number: int, newest: ca.SX | None = None) -> list[ca.SX]:
        """Steady speed that each command can cause on an axis: 0 while the base stands."""
        targets = super()._targets(way, number, newest)
        if self.rest is None:
            return targets
        held = [ca.SX(0) if newest is None else self.held, *(h.sym for h in self.held_before)]
        return [ca.if_else(h, 0, target) for h, target in zip(held, targets, strict=True)]

    @cached_property
    def onward(self) -> list[list[ToldBound]]:
        """`told`, extended by the command just sent."""
        return each_side(self._onward)

    def _onward(self, place: int, axis: int) -> ToldBound:
        m = self.told[place][axis]
        still = [*self._still(axis, self.safe), *m.still[1:]]
        return replace(m, most=[self.most[place][axis], *m.most[1:]], still=still)

    @cached_property
    def following(self) -> Sides:
        """Bounds of the speed at the next sample, after the safe command."""
        return each_side(lambda place, i: self.onward[place][i].following(
            self.start[place][i], self._targets(WAYS[place], i, self.safe)
        ))  # fmt: skip

    @cached_property
    def free_following(self) -> list[ca.SX]:
        """Free distances at the next sample."""
        return [self._free_following(place, i) for i in AXES for place in AXES]

    def _free_following(self, place: int, axis: int) -> ca.SX:
        motion, targets = self.onward[place][axis], self._targets(WAYS[place], axis, self.safe)
        latest = (1 + motion.schedule.jitter) * self.T
        gone = motion.until_next(self.start[place][axis], targets)
        V, nears = motion.bounds.V, self.stops[axis].nearing * latest
        gone = ca.if_else(self.trusted, gone, V * latest) + self.off(place, axis, latest)
        return self.free_now[place][axis] - gone - nears

    @cached_property
    def waiting(self) -> list[ca.SX]:
        """Sum of refused speeds away from each side.  It is reset when the request ends or
        passes.
        """
        return [self._waiting(place, i) for i in AXES for place in AXES]

    def _waiting(self, place: int, axis: int) -> ca.SX:
        others = [self.open[1 - place][axis], *(side[1 - axis] for side in self.open)]
        stands, leaves = self.held_before[0].sym, self.leaves[place][axis]
        before = self.waited.sym[place + 2 * axis]
        more = before + ca.fmax(self.pull[place][axis], 0)
        counts = reduce(ca.logic_and, (stands, leaves, *others))
        refused = ca.if_else(counts, more, PENDING * leaves)
        goes_on = ca.if_else(WAYS[place] * self.safe[axis] < 0, before, 0)
        return ca.if_else(self.opens, goes_on, refused)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Inputs of each step."""
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
            flags += ca.if_else(faster, SLOWING, 0) + unusable_limits(self.limits_told.sym)
        if self.distances:
            flags += ca.if_else(self.opens, 0, NEAR_BY) + ca.if_else(self.is_fresh, 0, NO_DISTANCE)
        return flags

    @property
    def memory(self) -> tuple[tuple[Port, ...], list[ca.SX]]:
        """State and its next values, those of the plain governor first."""
        state, update = super().memory
        own = self.watched
        if self.distances and self.rest is not None:
            own.append(([self.waited], self.waiting, 0))
        ports = (item for items, _, _ in own for item in items)
        values = (ca.if_else(self.sound, ca.vertcat(*new), other) for _, new, other in own)
        return (*state, *ports), [*update, *values]
