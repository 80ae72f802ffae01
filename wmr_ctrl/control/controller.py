"""controller: law, guard and map onto the wheels, as one sampled System, with or without a
monitor.
"""

from math import inf, nextafter

import casadi as ca

from wmr_ctrl.core.errors import show
from wmr_ctrl.core.signals import ASKED, FORCE, TORQUE, VELOCITY
from wmr_ctrl.world.model.dynamics import force_to_wheel, full_thrust, wheel_to_force
from wmr_ctrl.world.model.system import Output, Parameters, System, outputs, port, ports, stack
from wmr_ctrl.world.scenario import MissingKeysError, Scenario, missing_text, sections, unknown_keys

from .applied import Applied, Lateness, remembered
from .guard.bounds import ROUNDING, pair_of
from .guard.changing import changing_limits
from .guard.delay import Tails, delayed_push
from .guard.guard import MAPS, Bounds, bounds_of, guarded, linear_first, possible
from .guard.monitor import GuardMemory, LateMotion, monitored
from .laws.context import LawContext
from .laws.law import TorqueLimited
from .laws.registry import blamed_law
from .setup import Setup, settle
from .velocity import SentVelocity


def controller(setup: Setup) -> System:
    """The law, the guard if it is on, then the wheels' limit: tau_right, tau_left [N m].

    For a base that takes velocities: the law, an adapter if the law outputs a force, then the
    command filter if there is one: v_command [m/s], omega_command [rad/s].  This System supplies a
    law's inputs tau_applied and tau_sent: its state holds past commands and the drives' response to
    them.
    """
    return _composed(setup, watched=setup.scenario.guard.enabled)


def watched_controller(setup: Setup) -> System:
    """`controller` with the guard's diagnostics, whether it is on or off; torques are
    bit-identical.

    Without guard nothing is clipped (clip_active = 0), and d_least and feasible refer to the bounds
    that a guard would use: if they cannot be met, feasible = 0 and nothing is refused.
    """
    return _composed(setup, watched=True)


def asking_controller(setup: Setup) -> System:
    """`watched_controller` whose last diagnostic is the force that the law requests.

    That force is the input of `guard`: the law's output before this System's guard and wheel limit.
    """
    return _composed(setup, watched=True, asking=True)


def unfiltered_controller(setup: Setup) -> System:
    """`controller` of a base that takes velocities, for a filter elsewhere.

    Its output is v_asked; its input v_sent does not affect that output.
    """
    return _checked(setup, velocity_sender(setup, law_graph(setup)).asking())


def refusing_controller(setup: Setup) -> System:
    """`controller` of a base that takes velocities, for C, with inputs that may be refused."""
    return _checked(setup, velocity_sender(setup, law_graph(setup)).refusing())


def law_graph(setup: Setup, in_flight: int | None = None) -> System:
    """The law alone, whose output is the generalised force (N, N m).

    ``in_flight``: number of commands over which it predicts, by default that of the scenario's
    clock.
    """
    law = setup.control_law
    build = law.command if setup.takes_velocity and law.command else law.build
    with blamed_law(law, build):
        system = build(LawContext(setup, in_flight))
        if not isinstance(system, System):
            raise TypeError(f"it returns {show(system)}, not what context.system(...) gives")
        if [item.signal for item in system.outputs] not in ([FORCE], [ASKED]):
            raise ValueError("its System must have one output: FORCE, or ASKED")
    return system


def guard(setup: Setup) -> System:
    """The guard alone: requested force and measured velocity to wheel torques within tau_max."""
    asked, velocity = port(FORCE), ports(VELOCITY)
    p = Parameters(setup)
    applied, v = Applied(setup, p), stack(item.sym for item in velocity)
    torque, memory = _guarded_torque(setup, p, asked.sym, v, applied)
    return System(
        "guard",
        "velocity guard",
        inputs=(asked, *velocity, *memory.inputs),
        state=(*applied.state, *memory.state),
        params=p.ports,
        update=ca.vertcat(*applied.following(torque), memory.update),
        outputs=outputs(TORQUE, torque),
        diagnostics=memory.diagnostics,
        period=setup.scenario.clock.control,
    )


def _guarded_torque(
    setup: Setup, p: Parameters, asked: ca.SX, v: ca.SX, applied: Applied
) -> tuple[ca.SX, GuardMemory]:
    """Wheel torques (2,) [N m] of a guarded force, and the memory of monitor and guard."""
    r, half_track, phi = _wheels(setup, p)
    late = setup.guard.lateness(setup.scenario.clock)
    both, tails = bounds_of(p, late, setup.scenario.limits), Tails("guard_tail", late)
    changing = None
    if setup.guard.changing:
        both, changing = changing_limits(setup.scenario, p, both)
    sent = [wheel_to_force(r, half_track, item.sym) for item in applied.earlier]
    first, second = (
        delayed_push(sent, late[i], i, b, tails) for i, b in enumerate(map(both.axis, (0, 1)))
    )
    held = guarded(asked, v, both, (first, second))
    mapped = MAPS[setup.guard.map](held.force, phi, half_track, held.safe)
    torque = force_to_wheel(r, half_track, mapped)
    memory = _monitor(setup, p, both, v, applied, torque, held.active)
    if tails.state:
        following = tails.following([mapped, *sent], both)
        memory = memory.and_more(GuardMemory(tails.state, following))
    return torque, memory.and_more(changing) if changing else memory


def _limited_torque(setup: Setup, p: Parameters, asked: ca.SX) -> ca.SX:
    """Wheel torques (2,) [N m] of an unguarded force; the thrust has priority."""
    r, half_track, _ = _wheels(setup, p)
    return force_to_wheel(r, half_track, _reached(setup, p, asked))


def _reached(setup: Setup, p: Parameters, asked: ca.SX) -> ca.SX:
    """Part of a force (2,) [N, N m] that the wheels can exert; the thrust has priority."""
    _, half_track, phi = _wheels(setup, p)
    return linear_first(asked, phi, half_track)


def _monitor(
    setup: Setup,
    p: Parameters,
    both: Bounds,
    v: ca.SX,
    applied: Applied,
    torque: ca.SX,
    active: ca.SX,
) -> GuardMemory:
    r, half_track, phi = _wheels(setup, p)
    guard, clock, drives = setup.guard, setup.scenario.clock, setup.scenario.actuator
    flags = (active, possible(both, phi, half_track, _built_for(setup, p)))
    late = None
    if not guard.knows_force(drives.delay, drives.lag):
        torques = (torque, *(item.sym for item in applied.earlier))
        new, *sent = (wheel_to_force(r, half_track, tau) for tau in torques)
        late = LateMotion(guard.since_last(clock), sent, new)
    return monitored(both, v, applied.value, (r, half_track), flags, late)


def _built_for(setup: Setup, p: Parameters) -> list[ca.SX]:
    """Conditions that drives are neither slower, earlier nor more variable than assumed.

    They compare the settled numbers with those at run time, which may change.  Sums and differences
    that were rounded when the setup was settled get a tolerance: delays that other effects add, and
    the least value of a varying delay.
    """
    stated, bound, drives = setup.guard, setup.bound, setup.scenario.actuator
    met, near = [], 1 + ROUNDING
    if stated.latest > 0:
        delay, jitter = p.take("actuator.delay"), ca.SX(0)
        if drives.jitter > 0:
            jitter = p.take("actuator.jitter")
        others = bound.delay - (drives.delay + drives.jitter)
        latest = _counted(setup, p, stated.latest) * (near if others else 1)
        met.append(delay + jitter + others <= latest)
        if stated.jitter > 0:
            met.append((delay + others) * near >= _counted(setup, p, pair_of(stated.delay)[0]))
    if drives.lag > 0:
        (fast, slow), lag, spread = pair_of(stated.lag), p.take("actuator.lag"), ca.SX(0)
        if drives.lag_spread > 0:
            spread = p.take("actuator.lag_spread")
        met.append(lag * (1 + spread) <= _counted(setup, p, slow))
        if fast < slow:
            step = p.take("clock.plant")
            growth = ca.exp(step / (lag * (1 - spread))) - 1
            met.append(step >= _counted(setup, p, fast) * growth)
    return met


def _counted(setup: Setup, p: Parameters, time: float) -> ca.SX:
    """A time [s] that is constant in control periods, for the present clock period.

    At the settled period it is not less than the time, in double arithmetic.
    """
    period = setup.scenario.clock.control
    periods = time / period
    if periods * period < time:
        periods = nextafter(periods, inf)
    return p.take("clock.control") * periods


def _wheels(setup: Setup, p: Parameters) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Radius and half track [m], and the largest force 2 tau_max/r [N] of the wheels."""
    r, half_track = p.take("robot.r"), p.take("robot.l")
    return r, half_track, full_thrust(r, wheel_limit(setup, p))


def wheel_limit(setup: Setup, p: Parameters) -> ca.SX:
    """Torque limit of each wheel [N m]: the drives', or the law's own where it is smaller."""
    limit = p.take("actuator.tau_max")
    if isinstance(setup.gains, TorqueLimited):
        limit = ca.fmin(limit, p.take(f"gains.{setup.name}.tau_max"))
    return limit


def _composed(setup: Setup, *, watched: bool, asking: bool = False) -> System:
    core = law_graph(setup)
    if setup.takes_velocity:
        return _checked(setup, velocity_sender(setup, core).system())
    p = Parameters(setup, core.params)
    asked, known = core.outputs[0].expr, remembered(core)
    state, update, shown = [*core.state], [core.update], [*core.diagnostics]
    applied = Applied(setup, p, known) if watched or known else None
    v, monitor = stack(item.sym for item in core.inputs if item.signal in VELOCITY), None
    if applied and setup.scenario.guard.enabled:
        torque, monitor = _guarded_torque(setup, p, asked, v, applied)
    else:
        torque = _limited_torque(setup, p, asked)
    if applied and watched and monitor is None:  # of the bounds that a guard would use
        scenario = setup.scenario
        both = bounds_of(p, setup.guard.lateness(scenario.clock), scenario.limits)
        monitor = _monitor(setup, p, both, v, applied, torque, ca.SX.zeros(2))
    if applied:
        state += applied.state
        update += applied.following(torque)
    told = monitor.inputs if monitor else ()
    if monitor:
        state += monitor.state
        update.append(monitor.update)
        shown += monitor.diagnostics
    if asking:
        shown.append(Output(FORCE, asked))
    return System(
        core.name,
        core.title,
        inputs=(*(item for item in core.inputs if item not in known), *told),
        state=tuple(state),
        params=p.ports,
        update=ca.vertcat(*update),
        outputs=outputs(TORQUE, torque),
        diagnostics=tuple(shown),
        period=core.period,
    )


def velocity_sender(setup: Setup, core: System, late: Lateness | None = None) -> SentVelocity:
    """SentVelocity of a law for a base that takes velocities; ``late`` as in SentVelocity."""
    p = Parameters(setup, core.params)
    asked = core.outputs[0].expr
    direct = core.outputs[0].signal == ASKED
    return SentVelocity(setup, core, p, asked if direct else _reached(setup, p, asked), late)


def lacking(scenario: Scenario, law: str) -> tuple[str, ...]:
    """Keys of the robot that a law's controller needs and nobody states."""
    if not unknown_keys(scenario):
        return ()
    setup = settle(scenario, law)
    return _unknown_in(setup, velocity_sender(setup, law_graph(setup)).system())


def _unknown_in(setup: Setup, system: System) -> tuple[str, ...]:
    """Unstated keys of the robot that this System of a controller depends on."""
    scenario = setup.scenario
    unknown, result = unknown_keys(scenario), ca.vertcat(system.update, system.y)
    read = []
    for item in system.params if unknown else ():
        table, _, name = item.signal.name.partition(".")
        believed = table == "model" and vars(scenario.model)[name] is None
        key = f"robot.{name}" if believed else item.signal.name
        if key in unknown and ca.depends_on(result, item.sym):
            read.append(key)
    return tuple(dict.fromkeys(read))


def _checked(setup: Setup, system: System) -> System:
    """The controller itself; raises MissingKeysError if it depends on unstated numbers."""
    if lacks := _unknown_in(setup, system):
        raise MissingKeysError(f"law {setup.name}: {missing_text(lacks, sections())}")
    return system
