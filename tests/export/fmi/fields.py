"""Every field of a scenario, each with another value: what the walk over all fields takes."""

from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.core.fields.section import quantities
from wmr_ctrl.world.model.kinematics import KinematicGains
from wmr_ctrl.world.scenario import load_scenario, override
from wmr_ctrl.world.scenario.scenario import SECTIONS
from wmr_ctrl.world.scenario.sections import Change

FULL = {
    "clock.duration": 0.3,
    "robot": {"m": 52.0, "I": 5.0, "mu": 0.1},
    "model": {"m": 48.0, "I": 5.6, "mu": 0.07},
    "limits": {"v_u1": [0.3, 0.8], "v_u2": [0.15, 0.4], "clip": 0.02},
    "initial.velocity": [0.31, -0.95],
    "reference.rate": 0.3,
    "disturbance": {"std": 1.0, "truncate": 0.8, "push": [3.0, 0.5]},
    "sensor.pose_period": 0.04,
    "sensor.pose_noise": 0.01,
    "sensor.velocity_noise": [0.002, 0.004],
    "sensor.correction": 0.6,
    "actuator": {"tau_max": 6.0, "lag": 0.02, "delay": 0.003},
    "guard": {"enabled": True, "f_min": [1.0, 0.0], "f_speed": [0.2, 0.3]},
    "changes": [{"t": 0.1, "m": 60.0, "I": 6.0, "mu": 0.12}],
}
"""Everything on, and so strong that every field matters within 0.3 s."""
LOOSE = {
    **FULL,
    "guard": {"enabled": False},
    "actuator": {"tau_max": 60.0, "lag": 0.02, "delay": 0.003},
    "limits": {"v_u1": [1.0, 1.5], "v_u2": [0.1, 0.1], "clip": 0.02},
    "initial.velocity": [0.02, -0.3],
    "gains.pursuit": {"radius": 10.0, "slowest": 0.3, "share": 0.3, "turn": 0.1, "turn_from": 0.38},
}
"""The same without guard and with strong wheels, where gains have their say: pursuit turns on the
spot at first, then drives arcs that slow it down."""

OTHER = {
    "clock.control": 0.02,
    "clock.plant": 0.0005,
    "clock.duration": 0.2,
    "sensor.pose_period": 0.02,
    "actuator.delay": 0.013,
    "actuator.unmodelled_delay": 0.002,
    "sensor.pose_delay": 0.02,
    "sensor.pose_dropout": 0.5,
    "guard.M_min": [40.0, 4.0],
    "guard.M_max": [90.0, 9.0],
    "guard.dbar": [20.0, 5.0],
    "guard.nbar": [0.02, 0.01],
    "guard.alpha": 60.0,
    "guard.brake": [30.0, 9.0],
    "guard.f_min": [1.17, 0.0],
    "guard.f_speed": [0.27, 0.7],
    "gains.nn.ratio_cap": 1.01,
    "gains.pid.kinematics": [11.0, 6.0, 5.0],
    "gains.prox.kinematics": [11.0, 6.0, 5.0],
    "gains.kanayama.k": [0.1, 0.7, 0.2],
    "gains.pursuit.distance": [0.2, 0.4],
    "gains.pursuit.radius": 0.5,
    "gains.pursuit.turn_from": 0.2,
    "limits.v_min": [-0.29, -0.7],
    "limits.v_max": [0.29, 0.7],
    "metrics.split": 0.1,
    "body.radius": 0.3,
    "corridor.cells": 2,
    "corridor.losses": 2,
    "ros.base_frame": "base_footprint",
}
"""Values that the rule of `other` does not give."""


ELSEWHERE = {
    "sensor.velocity_window",
    "sensor.velocity_age",
    "sensor.velocity_losses",
    "actuator.jitter",
    "actuator.lag_spread",
    "actuator.traction",
    "guard.delay",
    "guard.lag",
    "guard.changing",
    "guard.falling",
    "reference.keep_out",
    "world.obstacles",
    "world.wall",
}
"""Fields that a guard or a coupled plant refuses: tests/world/test_effect.py has them.  Traction
limits weaker tyres than these: tests/simulation/physics/test_physics_grip.py has it.  Bounds of
delay and lag decide the form of a guard: tests/control/guard/test_lateness_runs.py; so do limits
that change: tests/control/guard/test_changing.py.  Obstacles change no motion of a robot that takes
torques: tests/corridor/test_clearance.py."""


def based(changes):
    """A scenario that has everything: of FULL or LOOSE."""
    return override(load_scenario("paper-simulation"), changes)


def other(key, what, value):
    """Another value of a field: an option, flag or name, or each number a little larger."""
    if key in OTHER:
        return OTHER[key]
    if what.options:
        return next(option for option in what.options if option != value)
    if isinstance(value, bool):
        return not value
    if isinstance(value, str):
        return f"{value}_too"
    if isinstance(value, tuple):
        return [number * (1.15 + 0.1 * i) + 0.02 for i, number in enumerate(value)]
    return min(value * 1.15 + 0.02, 1.0) if what.bounds.maximum == 1 else value * 1.15 + 0.002


def of_sections(base):
    """All fields but those of gains and references."""
    yield "name", {}
    yield "title", {"title": "Another title"}
    for section, cls in SECTIONS.items():
        if section not in ("filter", "base"):  # tests/control/test_velocity_base.py has them
            yield from _of(section, cls, getattr(base, section))
    yield from _of("changes[1]", Change, base.changes[0])


def of_gains(law):
    """The gains of one law, and of Eq. (7)."""
    yield from _of("gains.kinematics", KinematicGains, KinematicGains())
    yield from _of(f"gains.{law}", LAWS[law].gains, LAWS[law].gains())


def _of(section, cls, holder):
    for name, what in quantities(cls):
        key = f"{section}.{name}"
        if key in ELSEWHERE:
            continue
        yield key, {key: other(key, what, getattr(holder, name))}
