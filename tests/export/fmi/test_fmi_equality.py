"""One loop, five ways: NumPy, native, FMI 2 and FMI 3 in co-simulation, closed-loop FMU."""

import numpy as np
import pytest
from fmpy import simulate_fmu

from wmr_ctrl.api import simulate
from wmr_ctrl.core.signals import REFERENCE
from wmr_ctrl.export.cosim import cosimulate
from wmr_ctrl.world.references import sample
from wmr_ctrl.world.scenario import load_scenario, override

STATE = ("x", "y", "theta", "v1", "omega", "psi")
SHORT = override(
    load_scenario("paper-simulation"),
    {"clock.duration": 2.0, "changes": [{"t": 1.0, "m": 65.0, "mu": 0.15}]},
)


def assert_same(first, second, bound=0.0):
    """Equal columns to the bit, or within a bound, and equal findings."""
    for found in ("rows", "settings", "outcome") if bound else ("monitor", "settings", "outcome"):
        assert getattr(first, found) == getattr(second, found)
    for name in first.columns:
        own = bound + 1e-12 * (name == "e")  # NumPy's sine, not the kernel's
        np.testing.assert_allclose(first[name], second[name], rtol=0, atol=own, err_msg=name)


@pytest.mark.parametrize(
    "law, version",
    [("nn", 3), ("pid", 2), ("smc", 3), ("mb", 2), ("prox", 2), ("kanayama", 3), ("pursuit", 2)],
)
@pytest.mark.slow_but("nn-3")
def test_cosimulation_is_the_native_loop_to_the_bit(law, version):
    assert_same(simulate(SHORT, law, seed=3), cosimulate(SHORT, law, seed=3, fmi=version))


@pytest.mark.parametrize("law, version", [("nn", 3), ("prox", 2)])
@pytest.mark.slow_but("nn-3")
def test_closed_loop_fmu_is_the_native_loop_to_the_bit(exported, law, version):
    run = simulate("paper-simulation", law, seed=3)
    names = [name for signal in run.signals[1:] for name in signal.elements]
    found = simulate_fmu(
        str(exported("closed-loop", version, law=law)),
        stop_time=80.0,
        output_interval=0.01,
        step_size=0.01,
        start_values={"seed": 3},
        output=[*names, "violations", "max_abs_v[1]"],
    )
    for name in names:
        rows = found[name][:-1] if name in STATE else found[name][1:]
        assert np.array_equal(rows, run[name]), name
    assert found["violations"][-1] == run.monitor.violations
    assert found["max_abs_v[1]"][-1] == run.monitor.max_abs_v[0]


def test_change_inside_a_control_period():
    off = override(SHORT, {"changes": [{"t": 0.5034, "m": 80.0}]})
    assert_same(simulate(off, "mb", seed=2), cosimulate(off, "mb", seed=2), 1e-12)


def test_first_instant_of_a_step_counts_for_the_law(raw):
    """Inputs set before the step act in it, and are held until the next sample."""
    law = raw("mb", 2).new().begin()
    start = law.get("tau_right")[0]
    assert law.step(0.0, 0.01) == 0
    assert law.get("tau_right")[0] == start
    law.put({"v1": 0.3})
    assert law.get("tau_right")[0] == start
    assert law.step(0.01, 0.004) == 0
    moved = law.get("tau_right")[0]
    assert moved != start
    law.put({"v1": 0.1})
    assert law.step(0.014, 0.006) == 0
    assert law.get("tau_right")[0] == moved


def test_a_long_step_samples_at_each_period(raw):
    one, many = raw("nn", 2).new().begin(), raw("nn", 2).new().begin()
    assert one.step(0.0, 0.1) == 0
    for k in range(10):
        assert many.step(0.01 * k, 0.01) == 0
    assert one.all()[1:] == many.all()[1:]
    assert raw("nn", 2).new().begin().get("W_norm[1]") != one.get("W_norm[1]")


@pytest.mark.parametrize("version", [2, 3])
def test_model_exchange_with_cvode_agrees(exported, version):
    torque = {"tau_right": 6.0, "tau_left": 5.0}
    results = [
        simulate_fmu(
            str(exported("plant", version)),
            fmi_type=kind,
            stop_time=5.0,
            output_interval=0.01,
            start_values=torque,
            output=STATE,
            **({"solver": "CVode", "relative_tolerance": 1e-10} if kind == "ModelExchange" else {}),
        )
        for kind in ("CoSimulation", "ModelExchange")
    ]
    for name in STATE:
        assert np.abs(results[0][name] - results[1][name]).max() < 1e-6


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("step", [0.01, 0.02, 0.005])
def test_reference_is_that_of_the_time_that_was_reached(exported, version, step):
    """Not of the last sample's start, whatever the communication step is."""
    found = simulate_fmu(
        str(exported("reference", version)),
        stop_time=1.0,
        output_interval=step,
        step_size=step,
        fmi_type="CoSimulation",
    )
    wanted = sample(load_scenario("paper-simulation"), np.asarray(found["time"]))
    for k, signal in enumerate(REFERENCE):
        assert np.abs(found[signal.name] - wanted[:, k]).max() < 1e-12, signal.name
