"""Velocity for a base that takes velocities: the law's output, then the command filter.

A law that requests a force F is adapted by inverting the believed first-order loop of the base:

    a = M1^-1 (F - F1(v)),    u = v + s a,    s = T/(1 - exp(-T/tau)),

so that the mean acceleration of the sample is the requested one.  With M1 = diag(tau) and F1 = 0
that is u = v + F for T << tau.  Source: Martins, Sarcinelli-Filho and Carelli, A velocity-based
dynamic model and its properties for differential drive mobile robots (2017).  Their model also has
coupling and drag terms, which are 0 here.  The applied force is calculated from the command that
was sent, behind filter and known delay, so that an observer does not wind up.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import casadi as ca

from wmr_ctrl.core import signals
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.world.delay import in_periods
from wmr_ctrl.world.model.dynamics import force_to_wheel, reduced_mass
from wmr_ctrl.world.model.friction import friction
from wmr_ctrl.world.model.system import Output, Parameters, Port, System, outputs, port, stack
from wmr_ctrl.world.speed_loop_first_order import reach
from wmr_ctrl.world.speed_loops import lags
from wmr_ctrl.world.velocity_loss import VELOCITY_LOSS

from .applied import Lateness, followed, is_partial
from .filter.asked import turned
from .filter.channels import (
    BOUNDS_LEFT,
    ELAPSED,
    FLAGS,
    FREE,
    NEAR_BY,
    REFUSED,
    SENT,
    TOLD,
    has_bit,
    usable_command,
    within,
)
from .filter.filter import called_filter, filter_system
from .filter.heard import ODOMETRY
from .setup import Setup

FREE_NARROW = Signal(
    "free_narrow", "m, m, rad, rad", "`free` in the smallest window of headings", 4
)
"""Free distances for a command straight on, which is tried where `free` refuses one."""
NEAR = 1e-6
"""Share by which a velocity may differ from what was asked for, and yet be the same."""


class SentVelocity:
    """Law, adapter and filter of a setup, from the law's output to the velocity that is sent.

    ``wish``: the law's output, a force [N, N m] within the wheels' reach, or a velocity.
    """

    def __init__(
        self, setup: Setup, core: System, p: Parameters, wish: ca.SX, late: Lateness | None = None
    ) -> None:
        """Create the ports of the law's System ``core``, whose parameters are in ``p``.

        ``late``: the delay of commands, by default the scenario's.
        """
        self.setup, self.core, self.p, self.wish = setup, core, p, wish
        clock, delay = setup.scenario.clock, setup.scenario.base.delay
        self.late = late or (*in_periods(delay, setup.scenario), clock.substeps)
        self.v = stack(item.sym for item in core.inputs if item.signal in signals.VELOCITY)
        own = {item.signal: item for item in core.inputs}
        before = own.get(signals.SENT_BEFORE) or port(signals.SENT_BEFORE)
        ages = range(2, 2 + self.late[0] + is_partial(self.late[1]) - 1)
        words = ((f"v_sent_before{age}", f"velocity sent {age} samples ago") for age in ages)
        sent = (signals.Signal(name, "m/s, rad/s", meaning, 2) for name, meaning in words)
        self.earlier = (before, *map(port, sent))
        self.applied = own.get(signals.TAU_APPLIED)
        kind = setup.scenario.filter.kind
        self.filter = None if kind == "none" else filter_system(setup.scenario)
        inputs = self.filter.inputs if self.filter else ()
        read = {item.signal for item in inputs}
        dated = VELOCITY_LOSS in setup.effects and signals.ODOMETRY_AGE in read
        self.age = (port(signals.ODOMETRY_AGE),) if dated else ()
        self.told = tuple(item for item in inputs if item.signal in TOLD)
        self.narrow = (port(FREE_NARROW),) if FREE in read else ()

    @cached_property
    def F1(self) -> ca.SX:
        """Believed friction at the measured velocity (2,) [N, N m]."""
        return self._friction(self.v)

    def _friction(self, v: ca.SX) -> ca.SX:
        take = self.p.take
        return friction(take("model.mu"), take("model.m"), take("robot.g"), take("robot.v_s"), v)

    @cached_property
    def mass(self) -> ca.SX:
        """Believed mass and inertia (2,) [kg, kg m2]."""
        return reduced_mass(self.p.take("model.m"), self.p.take("model.I"))

    @cached_property
    def reach(self) -> ca.SX:
        """s (2,) [s], for the believed time constants."""
        scenario, take = self.setup.scenario, self.p.take
        if scenario.base.tau_believed is not None:
            tau = take("base.tau_believed")
        else:
            tau = ca.vertcat(*lags(scenario, take, self.mass))
        return reach(take("clock.control"), tau)

    @cached_property
    def asked(self) -> ca.SX:
        """Velocity (2,) that the law requests."""
        if self.core.outputs[0].signal == signals.ASKED:
            return self.wish
        return self.v + self.reach * (self.wish - self.F1) / self.mass

    @cached_property
    def filtered(self) -> tuple[ca.SX, ca.SX, ca.SX]:
        """The velocity that is sent (2,), the filter's flags and its next state."""
        if self.filter is None:
            return turned(self.setup.scenario, self.p, self.asked), ca.SX(0), ca.SX(0, 1)
        told = {item.signal: item.sym for item in (*self.age, *self.told)}
        wide = self._through(self.filter, {signals.ASKED: self.asked, **told})
        if not self.narrow:
            return wide
        told |= {signals.ASKED: ca.vertcat(self.asked[0], 0), FREE: self.narrow[0].sym}
        narrow = self._through(self.filter, told)
        near = ca.logic_and(has_bit(wide[1], NEAR_BY), self.asked[0] != 0)
        sent, flags, following = (
            ca.if_else(near, *pair) for pair in zip(narrow, wide, strict=True)
        )
        return sent, flags, following

    def _through(
        self, own: System, told: Mapping[signals.Signal, ca.SX]
    ) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Velocity sent (2,), flags and next state of the filter ``own``; missing inputs are 0."""
        known = {ODOMETRY: self.v, **told}
        inputs = stack(known.get(item.signal, ca.SX(0)) for item in own.inputs)
        p = stack(self.p.take(item.signal.name) for item in own.params)
        following, y = own.function("filter", [own.update, own.y])(inputs, own.x, p)
        rows = signals.places(item.signal for item in own.outputs)
        sent, flags = (y[rows[signal.name]] for signal in (SENT, FLAGS))
        return sent, flags, following

    def system(self) -> System:
        """The sampled System; its state is the law's, then the last commands, then the filter's.

        Of the guard's diagnostics ``clip_active`` says whether the filter changed the command,
        ``feasible`` whether odometry agrees with the stated bounds; pushes are not monitored.
        """
        sent, flags, filtering = self.filtered
        memory, following = self._remembering(sent)
        held = () if self.filter is None else self.filter.state
        changed = sent != self.asked
        if self.told:  # where something is near, turns that are nothing but roundings are 0
            changed = ca.fabs(sent - self.asked) > NEAR * self.p.take("limits.v_u1")
        agrees = ca.logic_not(has_bit(flags, BOUNDS_LEFT))
        watched = zip(signals.GUARD_DIAGNOSTICS, (changed, ca.SX.zeros(2), agrees), strict=True)
        shown = (Output(signals.ASKED, self.asked), Output(FLAGS, flags))
        diagnostics = (*self.core.diagnostics, *(Output(*item) for item in watched), *shown)
        update = ca.vertcat(self._learnt(sent), *following, filtering)
        inputs = (*self.age, *self.told, *self.narrow)
        law = self._around(memory, inputs, held, update, outputs(signals.COMMAND, sent))
        return replace(law, diagnostics=diagnostics)

    def refusing(self) -> System:
        """`system` for C on a robot, where inputs may be NaN and samples late.

        Further inputs are the odometry's age and the elapsed time, if the filter uses them, and
        ``refused``: then the request is (0, 0), the law keeps its memory, and odometry is not used.
        Outputs are the command and, with a filter, its flags and whether it changed the command.
        """
        refused = port(signals.REFUSED)
        asked = ca.if_else(refused.sym, 0, self.asked)
        told: tuple[Port, ...] = ()
        held: tuple[Port, ...] = ()
        shown: tuple[Output, ...] = ()
        sent, filtering = turned(self.setup.scenario, self.p, asked), ca.SX(0, 1)
        if self.filter is not None:
            own = called_filter(self.setup.scenario)
            given = (signals.ODOMETRY_AGE, ELAPSED)
            told = tuple(p for p in own.inputs if p.signal in (*given, *TOLD))
            held = own.state
            known = {item.signal: item.sym for item in told} | {signals.ASKED: asked}
            if signals.ODOMETRY_AGE in known:
                age = known[signals.ODOMETRY_AGE]
                known[signals.ODOMETRY_AGE] = ca.if_else(refused.sym, -1, age)
            sent, flags, filtering = self._through(own, known)
            flags += ca.if_else(refused.sym, REFUSED, 0)
            changed = ca.logic_or(sent[0] != asked[0], sent[1] != asked[1])
            shown = (Output(FLAGS, flags), Output(signals.GUARD_ACTED, changed))
        memory, following = self._remembering(sent)
        learnt = ca.if_else(refused.sym, self.core.x, self._learnt(sent))
        update = ca.vertcat(learnt, *following, filtering)
        command = (*outputs(signals.COMMAND, sent), *shown)
        return self._around(memory, (*told, refused), held, update, command)

    def asking(self) -> System:
        """`system` without the filter: its output is a requested velocity, its input the one sent.

        The further input v_sent affects only the memory, not the request; NaN is stored as 0.  It
        equals the memory of `system` to the bit.
        """
        sent, asked = port(SENT), self.asked
        usable = ca.vertcat(*usable_command(sent.sym)[0])
        memory, following = self._remembering(usable)
        update = ca.vertcat(self._learnt(usable), *following)
        return self._around(memory, (sent,), (), update, (Output(signals.ASKED, asked),))

    def _learnt(self, sent: ca.SX) -> ca.SX:
        """The law's next memory; estimates are frozen while the sent velocity differs from the
        request.

        The remaining error is then not due to the estimates.
        """
        if not self.setup.control_law.traits.integrates:
            return self.core.update
        near = [NEAR * (1 + ca.fabs(self.asked[i])) for i in (0, 1)]
        passed = ca.logic_and(*(within(sent[i] - self.asked[i], near[i]) for i in (0, 1)))
        return ca.if_else(passed, self.core.update, self.core.x)

    def _remembering(self, sent: ca.SX) -> tuple[list[Port], list[ca.SX]]:
        """Memory in addition to the law's, for the velocity sent (2,), and its next values."""
        memory: list[Port] = [*self.earlier]
        following = [sent, *(item.sym for item in self.earlier[:-1])]
        if self.applied is not None:
            memory.append(self.applied)
            following.append(self._acting(sent))
        return memory, following

    def _around(
        self,
        memory: Sequence[Port],
        inputs: Sequence[Port],
        held: Sequence[Port],
        update: ca.SX,
        shown: tuple[Output, ...],
    ) -> System:
        """The law with all parameters and further ports, except inputs that the memory supplies."""
        known, core = {item.signal for item in memory}, self.core
        own = (item for item in core.inputs if item.signal not in known)
        return System(
            core.name, core.title, inputs=(*own, *inputs), state=(*core.state, *memory, *held),
            params=self.p.ports, update=update, outputs=shown, period=core.period,
        )  # fmt: skip

    def _acting(self, sent: ca.SX) -> ca.SX:
        """Mean torque (2,) [N m] over the coming sample, by the believed speed loop."""
        commands = [sent, *(item.sym for item in self.earlier)]
        u, _ = followed(commands, self.late, ca.SX.zeros(2), 0.0)
        a = (u - self.v) / self.reach
        midway = self.v + a * self.p.take("clock.control") / 2
        force = self.mass * a + self._friction(midway)
        return force_to_wheel(self.p.take("robot.r"), self.p.take("robot.l"), force)
