"""The sampled loop around its reference as two graphs: the law per sample, the robot per step.

Both are the graphs that loops are compiled from (`wmr_ctrl.theory.checks.error_coordinates`, a
law's ``inside``), in error coordinates, each with its slopes and second derivatives in balls.  In
them

    command, memory  = law(e, v, memory, commands sent)        at a sample
    e, v, drives     = step(e, v, drives, command, push)       at every plant step

and both are the sum of their values on the reference, a linear part, and a remainder of second
order.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property

import casadi as ca
import numpy as np
from flint import arb

from wmr_ctrl.control.applied import followed, remembered
from wmr_ctrl.control.laws.context import LawContext
from wmr_ctrl.control.laws.observer import FORCE_HAT, OLD_VELOCITY
from wmr_ctrl.control.laws.registry import blamed_law
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.core.signals import TAU_APPLIED, TORQUE, Signal, places, tau_sent
from wmr_ctrl.theory.checks.error_coordinates import COMMAND, ROBOT, Floats, carried
from wmr_ctrl.theory.checks.loop import Loop
from wmr_ctrl.theory.checks.sending import SendingLoop
from wmr_ctrl.theory.checks.surroundings import surroundings
from wmr_ctrl.world.delay import delay_in_periods
from wmr_ctrl.world.model.dynamics import force_to_wheel
from wmr_ctrl.world.model.kinematics import error_rotation, tracking_error
from wmr_ctrl.world.model.system import System, port, stack
from wmr_ctrl.world.pose_sensor import corrected, reckoned
from wmr_ctrl.world.scenario import Robot, Scenario, override

from .condition import AXES, Asked, Condition
from .enclosure import Balls, BentEnclosure, Enclosure, upper
from .late_guard import commands_counted, late_conditions
from .overlap import ALONE, Overlap
from .sender import balanced, sending

BODY = ("robot.m", "robot.I")
"""Numbers of the robot that may lie in an interval."""


FREE, NOTHING = 1e300, np.zeros(0)
"""Size of a condition that nothing breaks; no sizes."""
UP = 1.0 + 1e-11
"""Factor that covers rounding in any sum of up to 4e4 doubles that are not negative."""
MOST_NUMBERS = 100
"""Most numbers of a loop's state."""
MOST_COLUMNS = 40_000
"""Most columns that are summed."""


class Curve:
    """A graph near a point: its values and gradient there, and second derivatives over a box."""

    def __init__(self, name: str, by: ca.SX, output: ca.SX, at: Floats) -> None:
        """Differentiate ``output`` by ``by`` near ``at``."""
        self.at, self.size = at, output.numel()
        self.by, self.output = by, output
        slope = ca.jacobian(output, by)
        self._value = Enclosure(name, [by], ca.densify(output))
        self._slope = Enclosure(f"the slope of {name}", [by], slope)
        self._bend = BentEnclosure(f"the bend of {name}", [by], output, by)

    def value(self) -> Balls:
        """Values at the point."""
        return self._value([arb(x) for x in self.at])

    def slopes(self) -> list[list[arb]]:
        """Jacobian at the point, in the current precision."""
        rows = [[arb(0)] * len(self.at) for _ in range(self.size)]
        point = [arb(x) for x in self.at]
        for (i, j), value in zip(self._slope.pattern, self._slope(point), strict=True):
            rows[i][j] = value
        return rows

    def remainders(self, products: Floats) -> Floats:
        """Linearisation remainders of each output, by pairs of inputs (outputs, n, n).

        ``products`` (n, n): the largest products of two inputs' deviations from the point, with
        squares of the box's sizes on the diagonal.  Raises OpenBoxError if the box crosses a
        condition.
        """
        peaks = np.sqrt(np.diag(products)) * UP
        box = [arb(x, r) for x, r in zip(self.at.tolist(), peaks.tolist(), strict=True)]
        sizes = np.zeros((self.size, *products.shape))
        for place, bend in zip(self._bend.bends, self._bend(box), strict=True):
            sizes[place] = 0.5 * upper(bend) * products[place[1:]] * UP
        return sizes


class LawLoop:
    """A law's loop in error coordinates: ``loop`` without limits, ``world`` around it, its graphs.

    ``conditions`` in the order of the law's outputs.  ``forces``: signals that the law reads beside
    its own memory.  ``late``: plant steps until a command acts.
    """

    def __init__(
        self,
        setup: Setup,
        asked: Asked,
        overlap: Overlap = ALONE,
        force_sizes: Floats = NOTHING,
    ) -> None:
        """Compose the law; ``asked``: conditions on its force and measured velocity.

        ``force_sizes``: force sizes for which a guard with late commands is checked.
        """
        self.setup, self.overlap, self.force_sizes = setup, overlap, force_sizes
        clock, around = setup.scenario.clock, surroundings(punctual(setup.scenario))
        self.steps, self._asked = clock.substeps, asked
        if setup.takes_velocity:
            self.loop: Loop = SendingLoop(setup, sender=self._inside(LawContext(setup)))
        else:
            self.loop = Loop(replace(setup, law=replace(setup.control_law, build=self._inside)))
        self.forces = [item.signal for item in remembered(self.loop.core)]
        self.world = around.worlds(clock.control)[0][1]
        self.names = self.world.names
        self.late = int(np.floor(around.drives.delay / clock.plant + 0.5))

    @property
    def count(self) -> int:
        """Number of conditions."""
        return len(self.conditions)

    @cached_property
    def filter(self) -> int:
        """Size of a corrected pose's part of the memory, its end.

        That is the estimated pose's error, and the velocity used for its dead reckoning.
        """
        return ROBOT if self.setup.scenario.sensor.correction < 1 else 0

    @cached_property
    def memory(self) -> int:
        """Size of the memory, which leaves out the law's last state: values of conditions."""
        core = self.loop.core
        return core.x.numel() - core.state[-1].signal.size + self.filter

    @cached_property
    def observed(self) -> tuple[int, int] | None:
        """Indices in the memory at which an observer's force and its remembered velocity begin."""
        rows = places(item.signal for item in self.loop.core.state)
        if OLD_VELOCITY.name not in rows:
            return None
        return rows[FORCE_HAT.name].start, rows[OLD_VELOCITY.name].start

    @cached_property
    def queue(self) -> int:
        """Number of commands in the state."""
        whole, part = delay_in_periods(self.setup.scenario)
        reach = whole + (part > 0) + 1 if TAU_APPLIED in self.forces else 0
        behind, left = divmod(self.late, self.steps)
        arriving = behind + (left > 0) + (self.overlap.steps > 0)
        return max(reach, self.setup.predicted, arriving, commands_counted(self.setup))

    @cached_property
    def acting(self) -> int:
        """Size of the acting command, where a law reads it behind a lag."""
        lags = self.setup.scenario.actuator.lag > 0
        return COMMAND if lags and TAU_APPLIED in self.forces else 0

    def _changes(self, changes: ca.SX) -> list[Condition]:
        """Conditions on the change from one command to the next; they are the last ones."""
        most = np.minimum(self.overlap.most, FREE)
        return [
            Condition(
                f"the command's change in a period ({axis})", changes[i], ca.SX(most[i]), inner=True
            )
            for i, axis in enumerate(AXES)
        ]

    def acts(self, s: int) -> tuple[int, float]:
        """Age of the command that acts at a plant step of a sample; share of the earlier one."""
        behind, rest = divmod(self.late, self.steps)
        phase, share = (s - rest) % self.steps, self.overlap.share
        return behind + (s < rest), float(share[phase]) if phase < len(share) else 0.0

    def _step_graph(self, v_d: ca.SX, changed: Mapping[str, ca.SX]) -> tuple[ca.SX, ca.SX]:
        """Fast state, command, push and BODY in one vector, and the fast state a plant step later.

        The reference moves at ``v_d``; ``changed``: other numbers of the robot by their names.
        """
        scenario, clock, world = self.setup.scenario, self.setup.scenario.clock, self.world
        sizes = (("z", world.size), ("u", COMMAND), ("d", COMMAND), ("body", COMMAND))
        z, u, push, body = (ca.SX.sym(name, n) for name, n in sizes)
        sends, around = self.setup.takes_velocity, surroundings(punctual(scenario))
        sent = u if sends else force_to_wheel(*_wheels(scenario.robot), u)
        known = around.numbers(world, clock.control, clock.plant, None)
        held = ca.vertcat(sent, push, ca.SX.zeros(world.held - 2 * COMMAND))
        numbers = ca.SX(ca.DM(known))
        for name, value in {**dict(zip(BODY, ca.vertsplit(body), strict=True)), **changed}.items():
            numbers[world.place(name)] = value
        after = world.step(0, z, z[2], held, numbers, v_d)  # seen by the robot: its theta = 0
        return ca.vertcat(z, u, push, body), after

    def _inside(self, context: LawContext) -> System:
        """The law away from its limits, with the conditions' values and sizes as further memory."""
        inside = self.setup.control_law.inside
        assert inside is not None
        with blamed_law(self.setup.control_law, inside):
            law = inside(context)
        if self.setup.takes_velocity:
            system, limits = sending(self.setup, law, self._asked)
        else:
            system, limits = law.system, self._asked(law.system.outputs[0].expr, context.v)
        self.conditions = limits + [
            Condition(
                f"{name} ({axis})", value[i], most[i], i if name in law.from_measured else None
            )
            for name, (value, most) in law.within.items()
            for i, axis in enumerate(AXES)
        ]
        values = stack(item.value for item in self.conditions)
        most = stack(ca.SX(item.most) for item in self.conditions)
        seen = port(Signal("conditions", "1", "values and sizes of conditions", 2 * most.numel()))
        update = ca.vertcat(system.update, values, most)
        return replace(system, state=(*system.state, seen), update=update)

    def _law_graph(
        self, v_d: ca.SX, rate: ca.SX, came: ca.SX
    ) -> tuple[ca.SX, ca.SX, ca.SX, list[Condition]]:
        """The law's inputs as one column, its outputs, sizes of the conditions' values, and these
        conditions.

        The reference's velocity is ``v_d``, its rate ``rate``, and its velocity in the previous
        sample ``came`` (2 each).
        """
        setup, scenario, count = self.setup, self.setup.scenario, self.count
        period, lag = scenario.clock.control, scenario.actuator.lag
        law_memory = self.memory - self.filter
        ages = {tau_sent(age): age for age in range(1, setup.predicted + 1)}
        s, own = ca.SX.sym("s", ROBOT), ca.SX.sym("memory", self.memory)
        shown = s
        if self.filter:
            share = ca.SX(scenario.sensor.correction)
            seen = estimated(own[law_memory:], s[:3], came, ca.SX(period), share)
            shown = ca.vertcat(seen, s[3:])
        sent, acting = ca.SX.sym("sent", COMMAND * self.queue), ca.SX.sym("acting", self.acting)
        queue = ca.vertsplit(sent, COMMAND) if self.queue else []
        forces, end = [], acting
        for signal in self.forces:
            if signal == TAU_APPLIED:
                decay = np.exp(-scenario.clock.plant / lag) if lag else 0.0
                late = (*delay_in_periods(scenario), self.steps)
                start = acting if self.acting else ca.SX.zeros(COMMAND)
                value, last = followed(queue, late, start, ca.SX(decay))
                end = last if self.acting else acting
            else:
                value = queue[ages[signal] - 1]
            forces.append(value)
        given = ca.vertcat(own[:law_memory], ca.SX.zeros(2 * count))
        numbers = ca.DM(self.loop.parameters(period))
        force, following = self.loop.act(shown, v_d, rate, given, ca.vertcat(*forces), numbers)
        by = ca.vertcat(s, own, sent, acting)
        sizes = following[law_memory + count :]
        values = following[law_memory : law_memory + count]
        further = list[Condition]()
        if self.force_sizes.size:
            further += late_conditions(setup, force, s[ROBOT - COMMAND :], queue, self.force_sizes)
        if self.overlap.steps:
            further += self._changes(force - sent[:COMMAND])
        values = ca.vertcat(values, *(item.value for item in further))
        sizes = ca.vertcat(sizes, *(item.most for item in further))
        output = ca.vertcat(force, following[:law_memory], shown[: self.filter], end, values)
        return by, output, sizes, self.conditions + further


class SampledLoop(LawLoop):
    """A law's loop on the reference.

    ``law``: function of (e, v, memory, sent, acting): command, next memory, acting command, and
    conditions' values.  ``step``: function of fast state, command, push and BODY: the fast state a
    plant step later.  ``remains``: outputs of the law on the reference, except conditions' values.
    """

    def __init__(
        self,
        setup: Setup,
        v_d: Floats,
        asked: Asked,
        overlap: Overlap = ALONE,
        force_sizes: Floats = NOTHING,
    ) -> None:
        """Compose the graphs; arguments as in LawLoop."""
        super().__init__(setup, asked, overlap, force_sizes)
        robot, point = setup.scenario.robot, self.loop.on_reference(np.array(v_d, dtype=float))
        rest, desired, drives = point.force, ca.SX(ca.DM(v_d)), self.world.fast[5:]
        if setup.takes_velocity:
            own = balanced(setup.scenario, drives, v_d)
        else:
            torque = _numbers(force_to_wheel(*_wheels(robot), ca.SX(ca.DM(rest))))
            own = np.concatenate((np.zeros(0), *(
                torque if item.signal.unit == TORQUE[0].unit else item.value for item in drives
            )))  # fmt: skip
        by, after = self._step_graph(desired, {})
        at = np.concatenate((point.s, own, rest, np.zeros(COMMAND), (robot.m, robot.I)))
        self.step = Curve("the robot", by, after, at)
        by, output, sizes, self.conditions = self._law_graph(desired, ca.SX.zeros(2), desired)
        seen = point.s[: self.filter]
        memory = np.concatenate((point.memory[: self.memory - self.filter], seen))
        sent, acting = np.tile(rest, self.queue), rest[: self.acting]
        self.remains = np.concatenate((rest, memory, acting))
        self.at = np.concatenate((point.s, own, sent, memory, acting))
        at = np.concatenate((point.s, memory, sent, acting))
        self.law = Curve("the law", by, output, at)
        self.limits = Curve("the limits", by, sizes, at)
        self.most = self.limits.value()

    @cached_property
    def reckoning(self) -> Curve:
        """Error (3) of dead reckoning over a sample, as a function of e and v (5) at its
        beginning.
        """
        at = self.step.at[:ROBOT]
        by, v_d = ca.SX.sym("s", ROBOT), ca.SX(ca.DM(at[3:]))
        period, none = ca.SX(self.setup.scenario.clock.control), ca.SX(0)
        ahead = estimated(by, ca.SX.zeros(3), v_d, period, none)
        return Curve("dead reckoning", by, ahead, at)


def punctual(scenario: Scenario) -> Scenario:
    """The scenario without jitter."""
    return override(scenario, {"actuator.jitter": 0.0}) if scenario.actuator.jitter else scenario


def estimated(past: ca.SX, e: ca.SX, v_d: ca.SX, T: ca.SX, share: ca.SX) -> ca.SX:
    """Error (3,) of the pose that the sensor estimates (see `wmr_ctrl.world.pose_sensor`).

    ``past``: that error and the velocity measured a sample ago (5,); ``e``: the true error now.
    """
    before = _placed(ca.SX.zeros(3), past[:3])
    desired = carried(ca.SX.zeros(3), v_d, T)
    seen = corrected(reckoned(before, past[3:], T), _placed(desired, e), share)
    return tracking_error(desired, seen)


def _placed(desired: ca.SX, e: ca.SX) -> ca.SX:
    """The pose (3,) with the tracking error e, Eq. (8), relative to the desired one."""
    return desired - error_rotation(desired[2] - e[2]).T @ e


def _wheels(robot: Robot) -> tuple[ca.SX, ca.SX]:
    return ca.SX(robot.r), ca.SX(robot.l)


def _numbers(value: ca.SX) -> Floats:
    return np.asarray(ca.evalf(value), dtype=float).ravel()
