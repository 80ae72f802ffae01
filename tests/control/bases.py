"""Bases that take velocities, with a speed loop of the first order, and one behind a governor."""

from wmr_ctrl.world.scenario import load_scenario, override

VELOCITY = {
    "base": {"kind": "velocity", "tau": [0.2, 0.25], "gain": [1.05, 0.95]},
    "clock.control": 0.05,
    "clock.duration": 6.0,
    "limits": {"v_u1": [1.0, 2.0], "v_u2": [0.7, 1.4]},
}
GOVERNED = {
    **VELOCITY,
    "filter": {
        "kind": "governor",
        "tau": [0.2, 0.3],
        "gain": [0.9, 1.1],
        "odometry": [0.01, 0.01],
    },
}


def based(overrides, **further):
    given = {**overrides, **{key.replace("__", "."): value for key, value in further.items()}}
    return override(load_scenario("paper-simulation-noise-free"), {"changes": [], **given})
