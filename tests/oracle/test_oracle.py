"""Whole runs of the NumPy oracle: columns, monitor, repeatability, and the paper's figures."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.oracle import simulate_oracle
from wmr_ctrl.world.scenario import load_scenario

KINEMATICS = {"k": (10.0, 5.0, 4.0)}
GAINS = {
    "pid": {"Kp": (210.0, 1.1), "Kd": (0.64, 0.08)},
    "smc": {
        "K": (200.0, 20.0),
        "eta": (5.0, 0.5),
        "boundary": 0.1,
        "v_s": 0.01,
        "g_m": 0.5,
        "g_F": 50.0,
        "axis_scale": (1.0, 0.1),
    },
    "mb": {"rho": (15.0, 57.6)},
    "nn": {
        "rho1": (1350.0, 21.6),
        "Gamma": (20000.0, 800.0),
        "sigma": (1e-4, 1e-4),
        "eta": math.sqrt(2.0),
        "node": 1.0,
        "ratio_cap": 1e3,
        "integrator": "explicit",
    },
}


def simulate(scenario, law, seed=0):
    return simulate_oracle(scenario, law, GAINS[law], KINEMATICS, seed)


def shortened(scenario, duration):
    """The scenario's first ``duration`` seconds."""
    changes = tuple(change for change in scenario.changes if change.t < duration)
    return replace(scenario, changes=changes, clock=replace(scenario.clock, duration=duration))


def test_first_row_is_the_start_with_its_known_errors():
    columns, _ = simulate(shortened(load_scenario("paper-simulation"), 0.01), "mb")

    assert columns["e"][0] == pytest.approx([0.70453, -0.06031, -0.87080], abs=1e-5)
    assert columns["v_c0"][0] == pytest.approx([7.174, -3.020], abs=1e-3)
    assert columns["v_c1"][0] == pytest.approx([0.84207, -1.3], abs=1e-5)
    assert columns["margin"][0] == 1.0


def test_unstable_gains_end_the_run_with_time_and_axis():
    scenario = load_scenario("paper-simulation-nominal")
    wild = {"Kp": (210.0, 1e5), "Kd": (0.0, 0.0)}
    columns, monitor = simulate_oracle(scenario, "pid", wild, KINEMATICS, 0)

    when, axis = monitor["stopped"]
    assert (monitor["stop_reason"], axis) == ("diverged", 2)
    assert len(columns["t"]) == math.ceil(when / 0.01 - 1e-9)
    assert np.abs(columns["omega"]).max() < 1e3 <= monitor["max_abs_v"][1]


def test_overflow_ends_the_run_as_non_finite():
    wild = GAINS["nn"] | {"rho1": (1e308, 1e308)}
    scenario = load_scenario("paper-simulation-nominal")
    columns, monitor = simulate_oracle(scenario, "nn", wild, KINEMATICS, 0)

    assert monitor["stop_reason"] in ("non-finite", "diverged")
    assert monitor["stopped"] == (0.001, 1)
    assert len(columns["t"]) == 1
    assert np.isfinite(monitor["max_abs_v"]).all()


def test_a_law_without_a_twin_is_refused():
    with pytest.raises(ValueError, match=r"pid, smc, mb, nn.*lqr"):
        simulate_oracle(load_scenario("paper-simulation"), "lqr", {}, KINEMATICS, 0)


# -- figures of whole runs ----


def ise(columns):
    pairs = (("x_d", "x"), ("y_d", "y"), ("theta_d", "theta"))
    return float(sum(((columns[a] - columns[b]) ** 2).sum() for a, b in pairs) * 0.01)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name, law, figure",
    [("paper-simulation-nominal", "pid", 2.34), ("paper-simulation", "nn", 0.857)],
)
def test_figures_of_the_papers_simulation(name, law, figure):
    columns, monitor = simulate(load_scenario(name), law)

    assert ise(columns) == pytest.approx(figure, rel=0.005)
    assert (monitor["violations"] == 0) == (law in ("mb", "nn"))
