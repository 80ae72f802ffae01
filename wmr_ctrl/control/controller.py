"""controller: law, guard and map onto the wheels, as one sampled System; watched or not."""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.control.applied import Applied
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.guard.guard import Bounds, bounds_of, guarded, possible
from wmr_ctrl.guard.monitor import GuardMonitor
from wmr_ctrl.guard.wheel_map import MAPS, linear_first
from wmr_ctrl.laws.law import TorqueLimited
from wmr_ctrl.laws.sample import Sample
from wmr_ctrl.model.dynamics import force_to_wheel, wheel_to_force
from wmr_ctrl.model.parameters import Parameters
from wmr_ctrl.model.system import Output, Port, System, port, ports, stack
from wmr_ctrl.signals import FORCE, TAU_APPLIED, TORQUE, VELOCITY


def controller(setup: Setup) -> System:
    """The law, the guard if it is on, then the wheels' limit: tau_right, tau_left [N m].

    A law's input tau_applied becomes state of this System, which remembers what it commanded and
    what the drives made of it.
    """
    return _composed(setup, watched=setup.scenario.guard.enabled)


def watched_controller(setup: Setup) -> System:
    """`controller` with the guard's diagnostics whether it is on or off; torques to the bit.

    Without guard nothing is clipped (clip_active = 0), and d_least and feasible are about the
    bounds that a guard would use: where they cannot be met, feasible = 0 and nothing is refused.
    """
    return _composed(setup, watched=True)


def law_graph(setup: Setup) -> System:
    """The law by itself, whose output is the generalised force (N, N m)."""
    return setup.control_law.build(Sample(setup))


def guard(setup: Setup) -> System:
    """The guard by itself: asked force and measured velocity to wheel torques within tau_max."""
    asked, velocity = port(FORCE), ports(VELOCITY)
    p = Parameters(setup)
    applied, v = Applied(setup, p), stack(item.sym for item in velocity)
    torque, monitor = _guarded_torque(setup, p, asked.sym, v, applied)
    return System(
        "guard",
        "velocity guard",
        (asked, *velocity),
        (*applied.state, *monitor.state),
        p.ports,
        ca.vertcat(*applied.following(torque), monitor.update),
        tuple(Output(signal, torque[i]) for i, signal in enumerate(TORQUE)),
        monitor.diagnostics,
        setup.scenario.clock.control,
    )


def _guarded_torque(
    setup: Setup, p: Parameters, asked: ca.SX, v: ca.SX, applied: Applied
) -> tuple[ca.SX, GuardMonitor]:
    """Wheel torques (2,) [N m] of a guarded force, and what watches over the guard's bounds."""
    r, half_track, phi = _wheels(setup, p)
    both = bounds_of(p, applied.under_way)
    sent = [(wheel_to_force(r, half_track, tau), share) for tau, share in applied.under_way]
    held = guarded(asked, v, both, sent)
    mapped = MAPS[setup.guard.map](held.force, phi, half_track, held.safe)
    torque = force_to_wheel(r, half_track, mapped)
    return torque, _monitor(p, both, v, applied, (r, half_track, phi), held.active)


def _watched_torque(
    setup: Setup, p: Parameters, asked: ca.SX, v: ca.SX, applied: Applied
) -> tuple[ca.SX, GuardMonitor]:
    """`_limited_torque`, and what watches over the bounds that a guard would use."""
    torque, both = _limited_torque(setup, p, asked), bounds_of(p, applied.under_way)
    return torque, _monitor(p, both, v, applied, _wheels(setup, p), ca.SX.zeros(2))


def _limited_torque(setup: Setup, p: Parameters, asked: ca.SX) -> ca.SX:
    """Wheel torques (2,) [N m] of a force without guard, the thrust served first."""
    r, half_track, phi = _wheels(setup, p)
    return force_to_wheel(r, half_track, linear_first(asked, phi, half_track))


def _monitor(
    p: Parameters,
    both: Bounds,
    v: ca.SX,
    applied: Applied,
    wheels: tuple[ca.SX, ca.SX, ca.SX],
    active: ca.SX,
) -> GuardMonitor:
    r, half_track, phi = wheels
    flags = (active, possible(p, both, phi, half_track))
    return GuardMonitor(both, v, applied.value, (r, half_track), flags)


def _wheels(setup: Setup, p: Parameters) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Radius and half track [m], and the force 2 tau_max/r [N] that the wheels give at most."""
    r, half_track, limit = p.take("robot.r"), p.take("robot.l"), p.take("actuator.tau_max")
    if isinstance(setup.gains, TorqueLimited):
        limit = ca.fmin(limit, p.take(f"gains.{setup.name}.tau_max"))
    return r, half_track, 2 * limit / r


def _composed(setup: Setup, *, watched: bool) -> System:
    core = law_graph(setup)
    p = Parameters(setup, core.params)
    asked = core.outputs[0].expr
    known = next((item for item in core.inputs if item.signal == TAU_APPLIED), None)
    if not (watched or known):
        return _finished(core, p, _limited_torque(setup, p, asked))
    applied = Applied(setup, p, known)
    if not watched:
        torque = _limited_torque(setup, p, asked)
        return _finished(core, p, torque, applied.state, applied.following(torque))
    act = _guarded_torque if setup.scenario.guard.enabled else _watched_torque
    torque, monitor = act(setup, p, asked, _velocity(core), applied)
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
