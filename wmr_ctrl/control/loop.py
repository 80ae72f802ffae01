"""The closed loop of a setup as two graphs, one a rate, over one state and one parameter vector.

    sample (every T)  reference, sensors, controller, disturbances  ->  what is held over the period
    step   (every h)  disturbances, drives, plant                   ->  the next fast state

The state is the fast one (the plant, then what moves with it at each step) followed by the slow
one.  Compiled loops and FMUs are made from these graphs and know no System by name.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import casadi as ca

from wmr_ctrl.control.controller import watched_controller
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.laws.sample import own_diagnostics
from wmr_ctrl.model.parameters import Parameters
from wmr_ctrl.model.plant import plant, rk4_step
from wmr_ctrl.model.system import NORMAL, Draw, Port, System, port, stack, values
from wmr_ctrl.model.tracking import tracking_error
from wmr_ctrl.results.assumptions import admitted, stopping_force
from wmr_ctrl.signals import (
    BODY_FORCE,
    LOG_HEAD,
    MEASURED_POSE,
    MEASURED_VELOCITY,
    PLANT_STATE,
    POSE,
    PSI,
    REFERENCE,
    SAMPLE,
    TIME,
    TORQUE,
    TORQUE_NOISE,
    TRACKING_ERROR,
    TRAVEL,
    VELOCITY,
    Signal,
)
from wmr_ctrl.world.effect import Effect, EffectRole, Rate
from wmr_ctrl.world.references.evaluate import reference

SUMS = ("position", "angle", "e1", "e2", "e3", "torque", "samples")
"""Per sample, added up over windows: dx^2 + dy^2 [m2], dtheta^2 [rad2], e_i^2, torque^2, 1."""
SEEN = (*SUMS, "peak", "clip1", "clip2", "least1", "least2", "beyond1", "beyond2")
"""What every run without a log watches: also the largest |torque| [N m], and of the guard's
monitor per axis whether it clipped, d_least [N, N m], and whether that contradicts the bounds."""
CLOCK = ("control", "plant", "delay_steps", "v_u1_linear", "v_u1_angular")
"""Numbers that the runtime takes from the parameters, before those of the streams."""
STREAMS = {"torque": 0, "pose": 1, "velocity": 2}
"""Streams whose numbers are fixed; others follow from their names."""
FIRST_STREAM = 16
TRAVELLED = Signal("travel_mark", "m, rad", "way and orientation at the previous sample", 2)
Named = dict[str, ca.SX]


@dataclass(frozen=True)
class Stream:
    """Random numbers of one draw: what picks them, their kind, how many, and at which rate."""

    draw: Draw
    rate: Rate

    @property
    def name(self) -> str:
        """Name of the stream."""
        return self.draw.port.signal.name

    @property
    def number(self) -> int:
        """Number of the stream in the generator's counter: it depends on the name alone."""
        return STREAMS.get(self.name, FIRST_STREAM + zlib.crc32(self.name.encode()))

    @property
    def size(self) -> int:
        """How many numbers."""
        return self.draw.port.signal.size

    @property
    def normal(self) -> bool:
        """Whether they are normal; else uniform on [-1, 1)."""
        return self.draw.kind == NORMAL


class LoopGraphs:
    """Both graphs of a setup's closed loop.

    ``k``: number of the sample; ``x``: the whole state; ``held``: what a sample leaves to its
    steps, the commanded torques first; ``row``: a line of the log; ``seen``: see SEEN.
    """

    def __init__(self, setup: Setup) -> None:
        """Compose all Systems of ``setup``."""
        self.setup = setup
        self.parameters = Parameters(setup)
        self.streams: list[Stream] = []
        self.k, self.i = port(SAMPLE), port(Signal("step", "1", "number of the plant step"))
        self.controller = watched_controller(setup)
        self._sensors = _built(setup, EffectRole.SENSOR, Rate.SAMPLE)
        odometer = any(TRAVEL.name in _names(system) for system in self._sensors)
        self.plant = plant(setup.scenario, odometer=odometer)
        self._fast: list[Port] = list(self.plant.state)
        self._slow: list[Port] = []
        self._slow_next: list[ca.SX] = []
        self._true = {item.signal.name: item.sym for item in self.plant.state}
        self.reference = reference(setup.scenario)
        self._sample()
        self._step()

    @property
    def fast(self) -> tuple[Port, ...]:
        """The part of the state that moves with every plant step, the plant's first."""
        return tuple(self._fast)

    @property
    def slow(self) -> tuple[Port, ...]:
        """The part of the state that moves with every sample."""
        return tuple(self._slow)

    @property
    def x(self) -> ca.SX:
        """The whole state."""
        return stack(item.sym for item in (*self._fast, *self._slow))

    @property
    def x_fast(self) -> ca.SX:
        """The fast state."""
        return stack(item.sym for item in self._fast)

    @property
    def x0(self) -> list[float]:
        """Start values of the whole state."""
        return values((*self._fast, *self._slow))

    @property
    def p(self) -> ca.SX:
        """The parameters."""
        return stack(item.sym for item in self.parameters.ports)

    @property
    def next_slow(self) -> ca.SX:
        """The slow state of the next sample."""
        return stack(self._slow_next)

    def draws(self, rate: Rate) -> ca.SX:
        """Random numbers of one rate."""
        return stack(item.draw.port.sym for item in self.streams if item.rate is rate)

    @cached_property
    def columns(self) -> tuple[Signal, ...]:
        """Signals of the log, in order."""
        pushed = BODY_FORCE if self._pushes else ()
        return (*LOG_HEAD, *own_diagnostics(self.controller), *pushed, *self._shown)

    @cached_property
    def row(self) -> ca.SX:
        """One line of the log."""
        return stack(self._named[signal.name] for signal in self.columns)

    @cached_property
    def seen(self) -> ca.SX:
        """What is watched in a run without a log, in the order of SEEN."""
        known, p = self._named, self.parameters
        off = stack(known[r.name] - known[s.name] for r, s in zip(POSE, REFERENCE[:3], strict=True))
        e, torque = known[TRACKING_ERROR.name], self.held[:2]
        peak = ca.fmax(ca.fabs(torque[0]), ca.fabs(torque[1]))
        least, u1 = known["d_least"], p.take("limits.v_u1")
        force = stopping_force(p.take("guard.M_max"), u1, p.take("clock.control"))
        most = admitted(p.take("guard.dbar"), force)
        sums = (off[0] * off[0] + off[1] * off[1], off[2] * off[2], e * e)
        squares = torque[0] * torque[0] + torque[1] * torque[1]
        beyond = [least[axis] > most[axis] for axis in (0, 1)]
        return ca.vertcat(*sums, squares, 1, peak, known["clip_active"], least, *beyond)

    @cached_property
    def clock(self) -> ca.SX:
        """Numbers of CLOCK, then for each stream whether it is drawn, and its bound."""
        p = self.parameters
        h = p.take("clock.plant")
        late = ca.floor(self._transport / h + 0.5)
        drawn = (self._resolved(item) for item in self.streams)
        return ca.vertcat(p.take("clock.control"), h, late, p.take("limits.v_u1"), *drawn)

    def _resolved(self, stream: Stream) -> ca.SX:
        """A stream's two numbers, by the loop's own parameters."""
        owner = self._owners[stream.name]
        both = ca.vertcat(stream.draw.wanted, stream.draw.bound)
        return ca.substitute(both, owner.p, self._of(owner))

    def _sample(self) -> None:
        scenario = self.setup.scenario
        time = self.k.sym * self.parameters.take("clock.control")
        known: Named = {**self._true, TIME.name: time, SAMPLE.name: self.k.sym}
        self._shown: list[Signal] = []
        self._owners: dict[str, System] = {}
        known[PSI.name] = self._true[POSE[2].name] + ca.pi / 2
        known |= self._run(self.reference, known, self._slow, self._slow_next)
        self._add_travel(known)
        for seen, true in zip(
            (*MEASURED_POSE, *MEASURED_VELOCITY), (*POSE, *VELOCITY), strict=True
        ):
            known[seen.name] = self._true[true.name]
        for system in self._sensors:
            known |= self._run(system, known, self._slow, self._slow_next, Rate.SAMPLE)
        known |= self._controlled(known)
        noise, pushed = self._disturbed(Rate.SAMPLE, known)
        known |= {s.name: noise[i] for i, s in enumerate(TORQUE_NOISE)}
        self._stepwise = _built(self.setup, EffectRole.DISTURBANCE, Rate.STEP)
        exerted = {s.name for s in BODY_FORCE}
        every = (*self._stepwise, *_built(self.setup, EffectRole.DISTURBANCE, Rate.SAMPLE))
        self._pushes = any(exerted & {o.signal.name for o in item.outputs} for item in every)
        known |= {s.name: pushed[i] for i, s in enumerate(BODY_FORCE)}
        desired, pose = (stack(known[s.name] for s in part) for part in (REFERENCE[:3], POSE))
        known[TRACKING_ERROR.name] = tracking_error(desired, pose)
        self._named = known
        torque = [known[s.name] for s in TORQUE]
        self.held = stack([*torque, *ca.vertsplit(noise), *(ca.vertsplit(pushed) * self._pushes)])
        assert scenario.clock.substeps >= 1

    def _add_travel(self, known: Named) -> None:
        """Way and turn since the previous sample, where a sensor asks for them."""
        if "path" not in self._true:
            return
        now, mark = stack((self._true["path"], self._true[POSE[2].name])), port(TRAVELLED)
        known[TRAVEL.name] = ca.if_else(self.k.sym > 0, now - mark.sym, ca.SX.zeros(2))
        self._slow.append(mark)
        self._slow_next.append(now)

    def _controlled(self, known: Named) -> Named:
        """What the controller gives for what was measured."""
        measured = zip((*POSE, *VELOCITY), (*MEASURED_POSE, *MEASURED_VELOCITY), strict=True)
        shown = known | {true.name: known[seen.name] for true, seen in measured}
        return self._run(self.controller, shown, self._slow, self._slow_next)

    def _disturbed(self, rate: Rate, known: Named) -> tuple[ca.SX, ca.SX]:
        """Sum of torques at the wheels (2,) and of forces on the body (2,) of one rate."""
        noise, pushed = ca.SX.zeros(2), ca.SX.zeros(2)
        state, following = (
            (self._slow, self._slow_next) if rate is Rate.SAMPLE else (self._fast, self._fast_next)
        )
        for system in _built(self.setup, EffectRole.DISTURBANCE, rate):
            given = self._run(system, known, state, following, rate)
            noise += stack(given.get(s.name, ca.SX(0)) for s in TORQUE_NOISE)
            pushed += stack(given.get(s.name, ca.SX(0)) for s in BODY_FORCE)
        return noise, pushed

    def _step(self) -> None:
        """The fast state after one plant step, from what is held and has arrived."""
        self.u = port(Signal("held", "1", "what a sample leaves to its steps", self.held.numel()))
        u, h = self.u.sym, self.parameters.take("clock.plant")
        self._fast_next: list[ca.SX] = []
        known = {**self._true, TIME.name: self.i.sym * h}
        known |= {s.name: u[i] for i, s in enumerate(TORQUE)}
        self._transport = ca.SX(0)
        for place, system in enumerate(_built(self.setup, EffectRole.DRIVE, Rate.STEP)):
            if system.transport is not None:
                if place:
                    raise ValueError(f"{system.name}: a delay must be the first of the drives")
                self._transport = ca.substitute(system.transport, system.p, self._of(system))
                continue
            known |= self._run(system, known, self._fast, self._fast_next, Rate.STEP)
        noise, pushed = self._disturbed(Rate.STEP, known)
        noise += u[2:4]
        pushed += u[4:6] if self._pushes else 0
        torque = stack(known[s.name] for s in TORQUE)
        moved = rk4_step(self.plant, ca.SX.sym("h"))
        inputs = ca.vertcat(torque, noise, pushed)
        step = ca.symvar(moved)
        width = next(item for item in step if item.name() == "h")
        old = ca.vertcat(self.plant.u, self.plant.p, width)
        moved = ca.substitute(moved, old, ca.vertcat(inputs, self._of(self.plant), h))
        self.next_fast = ca.vertcat(moved, *self._fast_next)

    def _run(
        self,
        system: System,
        known: Named,
        state: list[Port],
        following: list[ca.SX],
        rate: Rate = Rate.SAMPLE,
    ) -> Named:
        """Outputs and diagnostics of a System for what is known; its state joins the loop's."""
        for item in system.draws:
            self.streams.append(Stream(item, rate))
            self._owners[item.port.signal.name] = system
        u = stack(known[item.signal.name] for item in system.inputs)
        given = [u, system.x, self._of(system), *([system.w] if system.draws else [])]
        update, y, d = system.function("run", [system.update, system.y, system.d])(*given)
        state.extend(system.state)
        following.append(update)
        if system is not self.controller and system is not self.reference:
            self._shown.extend(item.signal for item in system.diagnostics)
        return _by_name(system, ca.vertcat(y, d))

    def _of(self, system: System) -> ca.SX:
        """The loop's symbols for a System's parameters."""
        return stack(self.parameters.take(item.signal.name) for item in system.params)


def _by_name(system: System, numbers: ca.SX) -> Named:
    signals, at, found = (*system.outputs, *system.diagnostics), 0, {}
    for item in signals:
        found[item.signal.name] = numbers[at : at + item.signal.size]
        at += item.signal.size
    return found


def _names(system: System) -> Iterable[str]:
    return (item.signal.name for item in system.inputs)


def _built(setup: Setup, role: EffectRole, rate: Rate) -> list[System]:
    chosen: list[Effect] = [item for item in setup.with_role(role) if item.rate is rate]
    return [item.build(setup.scenario) for item in chosen]


__all__ = ["CLOCK", "PLANT_STATE", "SEEN", "SUMS", "LoopGraphs", "Stream"]
