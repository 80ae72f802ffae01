"""The closed loop of a setup as two graphs, one per rate, with common state and parameters.

    sample (every T)  reference, sensors, controller, disturbances  ->  what is held over the period
    step   (every h)  disturbances, drives, plant                   ->  the next fast state

The state is the fast one (the plant, then what moves with it at each step) followed by the slow
one.  Compiled loops and FMUs are made from these graphs and know no System by name.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property, reduce
from typing import Any, cast

import casadi as ca

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.signals import (
    BODY_FORCE,
    COMMAND,
    DISTURBING,
    LARGEST,
    LOG_HEAD,
    MEASURED,
    ODOMETRY_AGE,
    PATH,
    POSE,
    PSI,
    REFERENCE,
    SKID,
    TORQUE,
    TRACKING_ERROR,
    TRAVEL,
    VELOCITY,
    Signal,
)
from wmr_ctrl.results.measures import AT_LIMIT
from wmr_ctrl.results.obstacles import distance
from wmr_ctrl.results.settings import admitted, stopping_force
from wmr_ctrl.world.effect import EffectRole, Rate
from wmr_ctrl.world.model.dynamics import KEYS, plant, rk4_step
from wmr_ctrl.world.model.kinematics import tracking_error
from wmr_ctrl.world.model.system import Parameters, Port, System, port, stack, values
from wmr_ctrl.world.phases import demanded
from wmr_ctrl.world.references.kind import reference
from wmr_ctrl.world.scenario import unknown_keys
from wmr_ctrl.world.sight import WIDEST, free_distances
from wmr_ctrl.world.speed_loop import EXERTED
from wmr_ctrl.world.standstill import BRAKED

from .controller import watched_controller, wheel_limit
from .filter.channels import FREE, FREE_AGE
from .filter.stop_numbers import smallest_window, stopping
from .laws.context import own_diagnostics
from .outside import check_outside_plant
from .setup import Setup
from .sides import LIMITS, sides
from .velocity import FREE_NARROW
from .wiring import Named, Stream, Wiring, held_signals, pushes

SUMS = ("position", "angle", "e1", "e2", "e3", "torque", "change", "samples", "needed", "saturated")
"""Per sample, added up over windows: dx^2 + dy^2 [m2], dtheta^2 [rad2], e_i^2, torque^2, the same
of the torque less the previous sample's, 1, torque^2 of what the desired motion needs, 1 where a
wheel is at its limit."""
WINDOW = (*SUMS, "farthest")
"""Columns of each window: the sums, and the largest of their first, dx^2 + dy^2 [m2]."""
SEEN = (*SUMS, "peak", "clip1", "clip2", "least1", "least2", "beyond1", "beyond2")
"""Monitor of every run without a log: also the largest |torque| [N m], and of the guard's
monitor per axis whether it clipped, d_least [N, N m], and whether that contradicts the bounds."""
GAP = "gap"
"""Name of the distance between body and nearest obstacle [m], logged if there are obstacles."""
SIDES = ("v_max_linear", "v_max_angular", "v_min_linear", "v_min_angular")
COUNTED = (*SIDES, "wheel_speed", "half_track")
CLOCK = ("control", "plant", "delay_steps", *COUNTED)
"""Numbers that the runtime takes from the parameters, before two for each stream: wanted, bound.
Beyond these limits of v and omega, or of a rim, and NO_VIOLATION a step counts as a violation."""
TRAVELLED = Signal("travel_mark", "m, rad", "way and orientation at the previous sample", 2)
TORQUE_BEFORE = Signal("tau_before", "N.m", "torque commanded at the previous sample", 2)
LOOK, LOOK_AHEAD = 0.3, 0.9
"""Headings to either side that are free where something is near [rad], and more of them for each
rad/s of the desired rotation [s]."""
NO_VIOLATION = 1e-12
"""Share of a limit by which a velocity may exceed it through rounding alone."""


class Graphs:
    """State, parameters, random numbers and acting forces of the graphs of both rates.

    ``sample`` and ``step``: the wirings of both rates; ``plant``: its state comes first; ``u``:
    values that a sample passes to its steps; ``acting``: torques and disturbances over a plant
    step; ``resting``: the fast state after it if the plant is external; ``clock``: see CLOCK;
    ``rolling``: plant outputs beside its state that sensors need; ``gap``: see GAP, () without.
    """

    parameters: Parameters
    plant: System
    rolling: tuple[Signal, ...]
    sample: Wiring
    step: Wiring
    u: Port
    acting: ca.SX
    _late: ca.SX
    _sides: tuple[ca.SX, ca.SX]
    _rim: ca.SX
    gap: tuple[ca.SX, ...] = ()

    @property
    def fast(self) -> tuple[Port, ...]:
        """The part of the state that changes with every plant step, the plant's first."""
        return (*self.plant.state, *self.step.state)

    @property
    def slow(self) -> tuple[Port, ...]:
        """The part of the state that changes with every sample."""
        return tuple(self.sample.state)

    @property
    def streams(self) -> tuple[Stream, ...]:
        """Random numbers of both rates."""
        return (*self.sample.streams, *self.step.streams)

    @property
    def x(self) -> ca.SX:
        """The whole state."""
        return stack(item.sym for item in (*self.fast, *self.slow))

    @property
    def x0(self) -> list[float]:
        """Start values of the whole state."""
        return values((*self.fast, *self.slow))

    @property
    def p(self) -> ca.SX:
        """The parameters."""
        return stack(item.sym for item in self.parameters.ports)

    @property
    def resting(self) -> ca.SX:
        """The fast state after a step of everything except the plant."""
        return ca.vertcat(self.plant.x, *self.step.following)

    def _join_sensors(self, setup: Setup, *, external_plant: bool) -> list[System]:
        """Create the plant, the wirings of both rates and the sensors; return the sensors."""
        self.parameters = Parameters(setup)
        sample = Wiring(setup, self.parameters, Rate.SAMPLE, {})
        sensors = sample.effects(EffectRole.SENSOR)
        self.rolling = rolling_of(sensors)
        rolling = self.rolling if external_plant else self.rolling[:1]
        self.plant = plant(setup.scenario, rolling=rolling)
        true: Named = {item.signal.name: item.sym for item in self.plant.state}
        sample.known |= {SKID.name: ca.SX(0), **true}
        self.sample = sample
        self.step = Wiring(setup, self.parameters, Rate.STEP, true)
        if any(item.signal == TRAVEL for system in sensors for item in system.inputs):
            now, mark = sample.column((PATH, POSE[2])), port(TRAVELLED)
            way = ca.if_else(sample.clock.sym > 0, now - mark.sym, ca.SX.zeros(2))
            sample.known[TRAVEL.name] = way
            sample.add((mark,), now)
        return sensors

    def _join_drives(self, drives: list[System], gusts: list[System], *, pushed: bool) -> None:
        """Add torques and disturbances over a plant step, from the held values."""
        rate = self.step
        signals = held_signals(rate.setup, pushed)
        self.u = port(Signal("held", "1", "what a sample leaves to its steps", len(signals)))
        rate.known |= {item.name: self.u.sym[i] for i, item in enumerate(signals)}
        self._late = rate.drive(drives)
        rate.disturb(gusts)
        self.acting = rate.column((*TORQUE, *DISTURBING))
        self._sides = sides(rate.setup.scenario.limits, self.parameters, -NO_VIOLATION)
        limited = rate.setup.takes_velocity and rate.setup.scenario.filter.wheel_speed is not None
        self._rim = self.parameters.take("filter.wheel_speed") if limited else ca.SX(LARGEST)

    def plant_step(self) -> ca.SX:
        """The fast state after a plant step, from held values and the arrived command."""
        h = ca.SX.sym("h")
        moved = rk4_step(self.plant, h)
        old = ca.vertcat(self.plant.u, self.plant.p, h)
        own, step = self.step.of(self.plant), self.parameters.take("clock.plant")
        new = ca.vertcat(self.acting, own, step)
        after, before = ca.substitute(moved, old, new), self.plant.x
        if (braked := self.step.known.get(BRAKED.name)) is not None:
            still = ca.vertcat(before[:3], 0, 0, before[5:])
            after = ca.if_else(braked, still, after)
        return ca.vertcat(after, *self.step.following)

    def _know_exerted(self, drives: list[System]) -> None:
        """Make the torques that the speed loop last exerted available to a sample.

        NaN if the robot's numbers are unknown.
        """
        every_state = (item for system in drives for item in system.state)
        exerted = next(item.sym for item in every_state if item.signal == EXERTED)
        nothing = math.nan if unknown_keys(self.sample.setup.scenario) else 0.0
        self.sample.known |= {item.name: exerted[i] + nothing for i, item in enumerate(TORQUE)}

    def draws(self, rate: Rate) -> ca.SX:
        """Random numbers of one rate."""
        return stack(item.draw.port.sym for item in self.streams if item.rate is rate)

    @cached_property
    def clock(self) -> ca.SX:
        """The numbers of CLOCK, then two for each stream."""
        h = self.parameters.take("clock.plant")
        steps = ca.floor(self._late / h + 0.5)
        said = (item.said for item in self.streams)
        ahead, back = self._sides
        counted = ahead, -back, self._rim * (1 + NO_VIOLATION), self.parameters.take("robot.l")
        return ca.vertcat(self.parameters.take("clock.control"), h, steps, *counted, *said)

    @cached_property
    def delay_steps(self) -> ca.Function:
        """Graph of the delay in plant steps as a function of the parameters."""
        return ca.Function("delay", [self.p], [self.clock[CLOCK.index("delay_steps")]])


class LoopGraphs(Graphs):
    """Both graphs of a setup's closed loop.

    ``fast`` and ``slow``: ports of the state; ``held``: values that a sample passes to its steps;
    ``columns`` and ``row``: a line of the log; ``seen``: see SEEN, then GAP.
    """

    def __init__(self, setup: Setup, *, external_plant: bool = False) -> None:
        if external_plant:
            check_outside_plant(setup)
        self.setup = setup
        self.controller, self.reference = watched_controller(setup), reference(setup.scenario)
        sensors = self._join_sensors(setup, external_plant=external_plant)
        drives = self.step.drives()
        self._compose_sample(sensors, drives)
        gusts = self.step.effects(EffectRole.DISTURBANCE)
        self._join_drives(drives, gusts, pushed=self._pushed)
        self.next_fast = self.plant_step()

    @property
    def next_slow(self) -> ca.SX:
        """The slow state at the next sample."""
        return stack(self.sample.following)

    @cached_property
    def columns(self) -> tuple[Signal, ...]:
        """Signals of the log, in order."""
        pushed = BODY_FORCE if self._pushed else ()
        sent = COMMAND if self.setup.takes_velocity else ()
        own = own_diagnostics(self.controller)
        columns = (*LOG_HEAD, *own, *sent, *pushed, *self.sample.shown)
        names = [item.name for item in columns]
        for item in self.sample.shown:
            if names.count(item.name) > 1:
                raise ArgumentError(
                    f"the diagnostic {item.name!r} of an effect has the name of another column. "
                    "The author of the effect must rename it."
                )
        return columns

    @cached_property
    def row(self) -> ca.SX:
        """One line of the log."""
        return self.sample.column(self.columns)

    @cached_property
    def seen(self) -> ca.SX:
        """Monitor of a run without a log, in the order of SEEN."""
        known, p = self.sample.known, self.parameters
        off = self.sample.column(POSE) - self.sample.column(REFERENCE[:3])
        e, torque = known[TRACKING_ERROR.name], self.sample.column(TORQUE)
        peak = ca.fmax(ca.fabs(torque[0]), ca.fabs(torque[1]))
        least = known["d_least"]
        sums = (ca.sumsqr(off[:2]), off[2] * off[2], e * e)
        before = next(item.sym for item in self.slow if item.signal == TORQUE_BEFORE)
        squares = ca.sumsqr(torque), ca.sumsqr(torque - before)
        needed = demanded(
            ca.vertcat(*map(p.take, KEYS)),
            *(self.sample.column(part) for part in (REFERENCE[3:5], REFERENCE[5:])),
        )
        if unknown_keys(self.setup.scenario):
            needed += math.nan
        at_limit = peak >= AT_LIMIT * wheel_limit(self.setup, p)
        summed = (*sums, *squares, 1, ca.sumsqr(needed), at_limit)
        guard = known["clip_active"], least, self._beyond(least)
        return ca.vertcat(*summed, peak, *guard, *self.gap)

    def _beyond(self, least: ca.SX) -> ca.SX:
        """1 where d_least (2,) contradicts the guard's bounds; 0 if the base takes velocities."""
        if self.setup.takes_velocity:
            return ca.SX.zeros(2)
        keys = ("guard.M_max", "limits.v_u1", "clock.control", "guard.dbar")
        mass, u1, period, dbar = (cast(Any, self.parameters.take(key)) for key in keys)
        most = admitted(dbar, stopping_force(mass, u1, period))  # symbols for floats
        return ca.vertcat(*(least[axis] > most[axis] for axis in (0, 1)))

    def _compose_sample(self, sensors: list[System], drives: list[System]) -> None:
        rate, known = self.sample, self.sample.known
        known[PSI.name] = known[POSE[2].name] + ca.pi / 2
        known |= rate.run(self.reference)
        rate.measure(sensors)
        measured = zip((*POSE, *VELOCITY), MEASURED, strict=True)
        shown = known | {true.name: known[seen.name] for true, seen in measured}
        if {LIMITS, FREE} & {item.signal for item in self.controller.inputs}:
            shown |= self._told()
        known |= rate.run(self.controller, shown)
        if self.setup.takes_velocity:
            self._know_exerted(drives)
        disturbances = rate.effects(EffectRole.DISTURBANCE)
        rate.disturb(disturbances)
        rate.add((port(TORQUE_BEFORE),), rate.column(TORQUE))
        every = [*disturbances, *self.step.effects(EffectRole.DISTURBANCE)]
        self._pushed = pushes(every)
        desired = rate.column(REFERENCE[:3])
        known[TRACKING_ERROR.name] = tracking_error(desired, rate.column(POSE))
        self.held = rate.column(held_signals(self.setup, self._pushed))
        if shapes := self.setup.scenario.obstacles:
            away = (distance(shape, known["x"], known["y"], ca) for shape in shapes)
            self.gap = (reduce(ca.fmin, away) - self.parameters.take("body.radius"),)

    def _told(self) -> Named:
        """Limits and free distances that a filter receives in a run.

        If no obstacle is near, any heading is free; otherwise only a window that suits the desired
        rotation.
        """
        scenario, settings = self.setup.scenario, self.setup.scenario.filter
        ahead, back = sides(scenario.limits, self.parameters)
        limits = ca.vertcat(-back[0], ahead[0], -back[1], ahead[1])
        told = {LIMITS.name: limits, FREE_AGE.name: ca.SX(0)}
        if settings.free_error is None:
            return told
        shapes, pose = scenario.obstacles, self.sample.column(POSE)
        radius = self.parameters.take("body.radius") if shapes else 0.0
        turns = ca.fabs(self.sample.known[REFERENCE[4].name])
        look = ca.fmin(LOOK + LOOK_AHEAD * turns, WIDEST)
        disc, *_ = free_distances(shapes, pose, (ca.SX(ca.pi), ca.SX(ca.pi)), radius)
        needs = [stopping(scenario, abs(speed)).distance for speed in scenario.limits.sides[0]]
        window = ca.if_else(disc >= max(needs), LARGEST, look)
        least = ca.SX(smallest_window(scenario)[1])
        for name, headings in ((FREE.name, window), (FREE_NARROW.name, least)):
            ways = free_distances(shapes, pose, (headings, headings), radius)
            told[name] = ca.vertcat(*ways, headings, headings)
        return told


class PlantlessGraphs(Graphs):
    """The loop without reference, controller and plant, which are connected from outside.

    ``measured``: sensor outputs, disturbances over the sample, ``columns`` of the log, and the age
    of the odometry if it varies (``dated``); ``steady``: whether all steps of a sample have the
    same inputs; ``calm``: whether they would with external drives.
    """

    def __init__(self, setup: Setup) -> None:
        sensors = self._join_sensors(setup, external_plant=True)
        self.sample.measure(sensors)
        disturbances = self.sample.effects(EffectRole.DISTURBANCE)
        self.sample.disturb(disturbances)
        drives, gusts = self.step.drives(), self.step.effects(EffectRole.DISTURBANCE)
        pushed = pushes([*disturbances, *gusts])
        exerted = TORQUE if setup.takes_velocity else ()
        if exerted:
            self._know_exerted(drives)
        self.columns = (*(BODY_FORCE if pushed else ()), *self.sample.shown, *exerted)
        self.dated = setup.takes_velocity and ODOMETRY_AGE.name in self.sample.known
        age = (ODOMETRY_AGE,) if self.dated else ()
        self.measured = self.sample.column((*MEASURED, *DISTURBING, *self.columns, *age))
        self.calm = not gusts
        self.steady = not drives and self.calm
        self._join_drives(drives, gusts, pushed=True)


def rolling_of(sensors: Sequence[System]) -> tuple[Signal, ...]:
    """Plant outputs beside its state that sensors need: none, PATH, or PATH and SKID."""
    asked = {item.signal for system in sensors for item in system.inputs}
    way = (PATH,) if asked & {PATH, SKID, TRAVEL} else ()
    return (*way, *((SKID,) if SKID in asked else ()))
