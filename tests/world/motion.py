"""Effects whose numbers matter, their scenarios, and a motion as input for their Systems."""

import casadi as ca
import numpy as np

from tests.tables import changes
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.world.effect import EffectRole
from wmr_ctrl.world.model.evaluate import evaluated
from wmr_ctrl.world.registry import EFFECTS as REGISTRY
from wmr_ctrl.world.scenario import load_scenario, override

SHORT = {"clock.duration": 0.5, "disturbance.std": 0.5, "disturbance.truncate": 3.0}
EFFECTS = {
    name.strip(): changes(text)
    for name, text in (line.split(" | ") for line in """
        encoder | encoder.counts = 1024
        encoder over a window | encoder.counts = 1024; encoder.window = 0.03
        encoder by time | encoder.counts = 1024; encoder.method = time
        averaged velocity | sensor.velocity_window = 0.02
        late velocity | sensor.velocity_age = 0.01
        lost velocities | sensor.velocity_losses = 3
        gyro | gyro.enabled = true; gyro.bias = 0.01; gyro.noise = 0.01
        late pose | sensor.pose_delay = 0.05
        lost poses | sensor.pose_dropout = 0.3; sensor.pose_noise = 0.02
        jitter | actuator.jitter = 0.005
        jitter of a delay | actuator.jitter = 0.01; actuator.delay = 0.007
        untold delay | actuator.unmodelled_delay = 0.004
        lag that varies | actuator.lag = 0.02; actuator.lag_spread = 0.5
        motor | motor.step = 0.2; motor.dead_zone = 0.1; motor.stall = 20.0; motor.free = 30.0
        wheels | wheels.radius = [0.02, -0.01]; wheels.track = 0.02
        slope | slope.angle = 0.03; slope.direction = 0.5; slope.offset = 0.02
        resistance | resistance.rolling = [0.01, 0.012]; resistance.viscous = [2.0, 0.1]
        gust | gust.size = [5.0, 1.0]; gust.time = 0.1
    """.strip().splitlines())
}  # fmt: skip
PARTS = ("encoder over a window", "gyro", "late pose", "lost poses", "jitter of a delay",
         "lag that varies", "motor", "wheels", "slope", "resistance", "gust")  # fmt: skip
TOGETHER = {key: value for part in PARTS for key, value in EFFECTS[part].items()}
ALL = {**EFFECTS, "all at once": TOGETHER}
LAW = "mb"


def scenario(stated):
    return scenario_of("paper-simulation", {**SHORT, **stated})


def motion(count=400, late=0):
    """Columns (N,) or (N, 2) of a wandering motion: path length, torques and random numbers.

    Torques of up to 10 N m are behind a constant delay of ``late`` rows.
    """
    rng = np.random.default_rng(7)
    v, omega = (np.cumsum(rng.normal(0, size, count)) for size in (0.05, 0.1))
    torque = rng.uniform(-10, 10, (count // 10 + 1, 2)).repeat(10, axis=0)[:count]
    torque = np.vstack((np.zeros((late, 2)), torque))[:count]
    columns = {
        "x": rng.normal(size=count), "y": rng.normal(size=count), "v1": v, "omega": omega,
        "path": np.cumsum(v) * 0.01, "theta": np.cumsum(omega) * 0.01, "skid": 0.0 * v,
        "torque": torque, "tau_right": torque[:, 0], "tau_left": torque[:, 1],
    }  # fmt: skip
    columns |= {f"{name}_measured": columns[name] for name in ("x", "y", "theta")}
    columns |= dict.fromkeys(("jitter", "gust"), rng.uniform(-1, 1, (count, 2)))
    return columns | dict.fromkeys(("sample", "step"), np.arange(count))


def fed(system, columns):
    """Outputs of a System, one row for each row of the columns."""
    graph = system.function("fed", [ca.densify(system.update), ca.densify(system.y)])
    x, shown = system.x0, []
    inputs = [item.signal.name for item in system.inputs]
    draws = [item.port.signal.name for item in system.draws]

    def at(row, names):
        return np.hstack([[], *(columns[name][row] for name in names)])

    for k in range(len(columns["x"])):
        drawn = [at(k, draws)] if draws else []
        x, y = evaluated(graph, at(k, inputs), x, system.p0, *drawn)
        shown.append(y.ravel())
    return np.array(shown)


def fed_to(effect, stated, columns):
    """Outputs of an effect's System for a motion."""
    return fed(effect.build(scenario(stated)), columns)


def bound_of(effect, stated):
    assert effect.bound is not None
    return effect.bound(scenario(stated))


BASE = {
    "changes": [],
    "base": {"kind": "velocity"},
    "clock.control": 0.05,
    "clock.duration": 3.0,
    "limits": {"v_u1": [1.0, 2.0], "v_u2": [0.7, 1.4]},
}


def based(**base):
    given = {**BASE, "base": {"kind": "velocity", **base}}
    return override(load_scenario("paper-simulation-noise-free"), given)


def acting(scenario, commands, draws=(), effect=None):
    """Return an effect's output for commands (N, 2), one per plant step.

    ``effect`` is the last one by default.
    """
    system = (effect or REGISTRY.present(scenario, EffectRole.COMMAND)[-1]).system(scenario)
    graph = system.function("act", [ca.densify(system.update), ca.densify(system.y)])
    state, rows = np.array(system.x0), []
    for number, command in enumerate(commands):
        given = [*command, *([number] if len(system.inputs) > 2 else [])]
        drawn = [[draws[number], 0.0]] if system.draws else []
        state, y = evaluated(graph, given, state, system.p0, *drawn)
        rows.append(y.ravel())
    return np.array(rows)
