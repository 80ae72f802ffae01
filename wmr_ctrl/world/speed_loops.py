"""Speed loops of both axes, joined: wheel torques from a command and the true speed."""

from __future__ import annotations

from wmr_ctrl.core.signals import COMMAND, TORQUE, VELOCITY
from wmr_ctrl.core.symbolic import ca

from .effect import Bound, Effect, EffectRole, Rate, Scenario
from .model.dynamics import KEYS, force_to_wheel, reduced_mass
from .model.friction import friction
from .model.system import Parameters, System, outputs, port, ports, stack
from .speed_loop import EXERTED, BaseKind, Drive, Loop, Numbers, Servo
from .speed_loop_first_order import FIRST_ORDER
from .speed_loop_pi import PI
from .speed_loop_second_order import SECOND_ORDER

KINDS: dict[str, Loop] = {"first-order": FIRST_ORDER, "second-order": SECOND_ORDER, "pi": PI}


def loops_of(scenario: Scenario) -> list[Loop]:
    """The loops of v and of omega."""
    return [KINDS[name] for name in scenario.section(BaseKind).loop]


def lags(scenario: Scenario, take: Numbers, mass: ca.SX) -> list[ca.SX]:
    """Time constants (2) [s] that laws assume, for a base of this mass and inertia (2)."""
    return [loop.lag(take, axis, mass[axis]) for axis, loop in enumerate(loops_of(scenario))]


def assumed_lags(scenario: Scenario) -> list[float]:
    """`lags` as numbers: base.tau_believed if it is stated, else for the believed mass."""
    mass = ca.SX([scenario.believed.m, scenario.believed.I])
    own = lags(scenario, lambda key: ca.SX(scenario.value(key)), mass)
    return [*(scenario.base.tau_believed or map(float, own))]


def build(scenario: Scenario) -> System:
    """Plant-rate System: from commanded and true velocity to wheel torques [N m]."""
    command, velocity, p = ports(COMMAND), ports(VELOCITY), Parameters(scenario)
    u, v = (stack(item.sym for item in side) for side in (command, velocity))
    m, inertia, mu, r, half_track, g, v_s = map(p.take, KEYS)
    F1, mass, h = friction(mu, m, g, v_s, v), reduced_mass(m, inertia), p.take("clock.plant")
    states = {loop: port(loop.state) for loop in loops_of(scenario) if loop.state}
    drives = list[Drive]()
    for i, loop in enumerate(loops_of(scenario)):
        own = states[loop].sym[i] if loop in states else ca.SX(0)
        drives.append(loop.drive(Servo(scenario, p, i, u[i], v[i], mass[i], F1[i], h, own)))
    most = p.take("actuator.tau_max")
    wanted = force_to_wheel(r, half_track, ca.vertcat(*(drive.force for drive in drives)))
    torque = ca.fmax(-most, ca.fmin(most, wanted))
    following = [drive.following(torque - wanted) for drive in drives]
    updates = [
        following[i] if loop is own else ca.SX(0)
        for loop in states
        for i, own in enumerate(loops_of(scenario))
    ]
    return System(
        "speed_loop",
        "speed loop of the base",
        inputs=(*command, *velocity),
        state=(port(EXERTED), *states.values()),
        params=p.ports,
        update=ca.vertcat(torque, *updates),
        outputs=outputs(TORQUE, torque),
    )


def bound(scenario: Scenario) -> Bound:
    """Bound of the loops: none for a loop that overshoots; the governor itself models first order.

    With a torque limit, a first-order loop is a hidden effect.
    """
    for name in scenario.section(BaseKind).loop:
        if KINDS[name].overshoots:
            said = f'base.loop = "{name}": after a step the speed exceeds its command.'
            return Bound(overshoots=said)
    if scenario.actuator.tau_max < float("inf"):
        return Bound(hidden="actuator.tau_max: the speed is slower than first order at the limit.")
    return Bound()


SPEED_LOOP = Effect(
    "speed loop", EffectRole.LOOP, BaseKind, build, bound, acts=lambda _: True, rate=Rate.STEP
)
