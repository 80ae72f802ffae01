"""One loop, five ways: NumPy, native, FMI 2 and FMI 3 in co-simulation, closed-loop FMU."""

import numpy as np
import pytest
from fmpy import simulate_fmu

from tests.export.fmi.cases import both
from tests.export.fmi.raw import OK
from wmr_ctrl.api import simulate
from wmr_ctrl.core.signals import REFERENCE
from wmr_ctrl.export.cosim import cosimulate
from wmr_ctrl.world.references import sample
from wmr_ctrl.world.scenario import load_scenario, override

REACHED = ("x", "y", "theta", "v1", "omega", "psi")
"""Outputs of the closed loop for the instant reached; all others are of the last sample."""
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


def assert_loop_is(run, fmu, numbers=(), seed=0):
    """A closed loop with other numbers has the columns and findings of a run, bit by bit."""
    names = [name for signal in run.signals[1:] for name in signal.elements]
    most, shown = ["max_abs_v[1]", "max_abs_v[2]"], set(fmu.outputs)
    loop, period = fmu.new(), run.settings.control
    assert shown == {*names, *most, "violations"}
    assert loop.put(dict(numbers)) == OK, fmu.messages[-1:]
    assert loop.integer("Set", "seed", seed)[0] == OK
    rows = [loop.begin().get(*names)]
    for k in range(run.rows):
        assert loop.step(k * period, period) == OK
        rows.append(loop.get(*names))
    for name, column in zip(names, np.transpose(rows), strict=True):
        wanted, own = np.array(run[name], float), column[:-1] if name in REACHED else column[1:]
        assert own.tobytes() == wanted.tobytes(), name
        assert column[:1].tobytes() == wanted[:1].tobytes(), name
    assert tuple(loop.get(*most)) == run.monitor.max_abs_v
    assert loop.integer("Get", "violations") == (OK, run.monitor.violations)


@pytest.mark.parametrize("law, version", [("nn", 3), ("prox", 2)])
@pytest.mark.slow_but("nn-3")
def test_closed_loop_fmu_is_the_native_loop_to_the_bit(raw, monkeypatch, law, version):
    """Runs of 80 s are equal; one library is built by zig, as it is shipped."""
    for variable in ("WMR_CTRL_OPTIMIZE", "WMR_CTRL_FMU_CC") if law == "prox" else ():
        monkeypatch.delenv(variable, raising=False)
    run = simulate("paper-simulation", law, seed=3)
    assert_loop_is(run, raw("closed-loop", version, law=law), seed=3)


def test_change_inside_a_control_period():
    off = override(SHORT, {"changes": [{"t": 0.5034, "m": 80.0}]})
    assert_same(simulate(off, "mb", seed=2), cosimulate(off, "mb", seed=2), 1e-12)


@both
def test_model_exchange_with_cvode_agrees(exported, version):
    given = {"stop_time": 5.0, "output_interval": 0.01, "output": REACHED}
    given["start_values"] = {"tau_right": 6.0, "tau_left": 5.0}
    kinds = {"CoSimulation": {}, "ModelExchange": {"solver": "CVode", "relative_tolerance": 1e-10}}
    one, other = (
        simulate_fmu(str(exported("plant", version)), fmi_type=kind, **given, **more)
        for kind, more in kinds.items()
    )
    for name in REACHED:
        assert np.abs(one[name] - other[name]).max() < 1e-6


@both
@pytest.mark.parametrize("step", [0.01, 0.02, 0.005])
def test_reference_is_that_of_the_time_that_was_reached(exported, version, step):
    """With any communication step, the reference is not still that of the last sample."""
    path = str(exported("reference", version))
    times = {"stop_time": 1.0, "output_interval": step, "step_size": step}
    found = simulate_fmu(path, fmi_type="CoSimulation", **times)
    wanted = sample(load_scenario("paper-simulation"), np.asarray(found["time"]))
    for k, signal in enumerate(REFERENCE):
        assert np.abs(found[signal.name] - wanted[:, k]).max() < 1e-12, signal.name
