"""controller: law, guard and map onto the wheels, as one sampled System; watched or not."""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.control.applied import Applied
from wmr_ctrl.guard.bounds import stated_guard, wheel_limit
from wmr_ctrl.guard.guard import bounds_of, guarded_torque, possible
from wmr_ctrl.guard.monitor import Monitor
from wmr_ctrl.guard.wheel_map import linear_first
from wmr_ctrl.laws.registry import LAWS
from wmr_ctrl.model.dynamics import force_to_wheel
from wmr_ctrl.model.parameters import Parameters
from wmr_ctrl.model.system import Output, Port, System, stack
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import TAU_APPLIED, TORQUE, VELOCITY


def controller(scenario: Scenario, law: str) -> System:
    """The law, the guard if it is on, then the wheels' limit: tau_right, tau_left [N m].

    A law's input tau_applied becomes state of this System, which remembers what it commanded and
    what the drives made of it.  Raises ScenarioError where the guard's settings cannot be met.
    """
    return _composed(scenario, law, watched=scenario.guard.enabled)


def watched_controller(scenario: Scenario, law: str) -> System:
    """`controller` with the guard's diagnostics whether it is on or off; torques to the bit.

    Without guard nothing is clipped (clip_active = 0), and d_least and feasible are about the
    bounds that a guard would use: where they cannot be met, feasible = 0 and nothing is refused.
    """
    return _composed(scenario, law, watched=True)


def limited_torque(scenario: Scenario, p: Parameters, asked: ca.SX, law: str) -> ca.SX:
    """Wheel torques (2,) [N m] of a force without guard, the thrust served first."""
    r, half_track = p.take("robot.r"), p.take("robot.l")
    phi = 2 * wheel_limit(scenario, p, law).sym / r
    return force_to_wheel(r, half_track, linear_first(asked, phi, half_track))


def watched_torque(
    scenario: Scenario, p: Parameters, asked: ca.SX, v: ca.SX, applied: Applied, law: str
) -> tuple[ca.SX, Monitor]:
    """`limited_torque`, and what watches over the bounds that a guard would use."""
    torque = limited_torque(scenario, p, asked, law)
    r, half_track, limit = p.take("robot.r"), p.take("robot.l"), wheel_limit(scenario, p, law)
    both = bounds_of(p, stated_guard(scenario, limit.number), applied)
    flags = (ca.SX.zeros(2), possible(p, both, 2 * limit.sym / r, half_track))
    return torque, Monitor(both, v, applied.value, (r, half_track), flags)


def _composed(scenario: Scenario, law: str, *, watched: bool) -> System:
    core = LAWS[law].build(scenario)
    p = Parameters(scenario, core.params)
    asked = core.outputs[0].expr
    known = next((item for item in core.inputs if item.signal == TAU_APPLIED), None)
    if not (watched or known):
        return _finished(core, p, limited_torque(scenario, p, asked, law))
    applied = Applied(scenario, p, known)
    if not watched:
        torque = limited_torque(scenario, p, asked, law)
        return _finished(core, p, torque, applied.state, applied.following(torque))
    act = guarded_torque if scenario.guard.enabled else watched_torque
    torque, monitor = act(scenario, p, asked, _velocity(core), applied, law)
    update = [*applied.following(torque), monitor.update]
    state = (*applied.state, *monitor.state)
    return _finished(core, p, torque, state, update, monitor.diagnostics)


def _velocity(core: System) -> ca.SX:
    names = [item.name for item in VELOCITY]
    return stack(item.sym for item in core.inputs if item.signal.name in names)


def _finished(
    core: System,
    p: Parameters,
    torque: ca.SX,
    state: tuple[Port, ...] = (),
    update: list[ca.SX] | None = None,
    diagnostics: tuple[Output, ...] = (),
) -> System:
    """The law's System with the torques as outputs, further state and further diagnostics."""
    return System(
        core.name,
        core.title,
        tuple(item for item in core.inputs if item.signal != TAU_APPLIED),
        (*core.state, *state),
        p.ports,
        ca.vertcat(core.update, *(update or [])),
        tuple(Output(signal, torque[i]) for i, signal in enumerate(TORQUE)),
        (*core.diagnostics, *diagnostics),
        core.period,
    )
