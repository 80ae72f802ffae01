"""The registry's promise: an effect is a file and a line, and it acts or is refused."""

import numpy as np
import pytest
from fmpy import simulate_fmu

from tests.papers_robot import paper_toml
from tests.tables import changes
from tests.world import motion
from wmr_ctrl.api import export_fmu, simulate
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ArgumentError, ScenarioError, UnknownKeyError
from wmr_ctrl.world.effect import EffectRole
from wmr_ctrl.world.registry import EFFECTS
from wmr_ctrl.world.scenario import loads_scenario, to_toml

pytestmark = pytest.mark.usefixtures("toy_world")
SHORT = {"clock.duration": 1.5, "disturbance.std": 0.5, "disturbance.truncate": 3.0}
ONE_OF_EACH = """
    toy_gyro.walk = 0.001; toy_ramp.rate = 100.0; toy_slope.angle = 0.03; toy_gust.torque = 0.05
    reference.kind = toy-clothoid; sensor.velocity_noise = [0.01, 0.01]
"""
TOYS = {
    "sensor with state and draws": changes("toy_gyro.walk = 0.001"),
    "drive with state": changes("toy_ramp.rate = 100.0"),
    "drive behind a delay": changes("toy_ramp.rate = 100.0; actuator.delay = 0.007"),
    "force on the body": changes("toy_slope.angle = 0.03"),
    "draws in each step": changes("toy_gust.torque = 0.05"),
    "reference with state": changes("reference.kind = toy-clothoid"),
    "all at once": changes(ONE_OF_EACH),
}
LAW = "mb"


def run_of(name):
    return simulate("paper-simulation", LAW, seed=3, overrides={**SHORT, **TOYS[name]})


@pytest.mark.slow
def test_gusts_are_the_difference_of_two_pairs_of_numbers():
    run = run_of("draws in each step")

    assert not np.array_equal(
        run["x"], simulate("paper-simulation", LAW, seed=3, overrides=SHORT)["x"]
    )


def test_the_closed_loop_fmu_has_the_bits_of_the_native_loop(tmp_path):
    name = "all at once"
    run, scenario = run_of(name), scenario_of("paper-simulation", {**SHORT, **TOYS[name]})
    (path,) = export_fmu("closed-loop", law=LAW, scenario=scenario, fmi=3, out=tmp_path)
    shown = ["x", "tau_right", "noise_left", "V1"]
    times = {"stop_time": 1.5, "output_interval": 0.01, "output": shown}
    table = simulate_fmu(str(path), start_values={"seed": 3}, **times)

    assert (table["x"][:150] == run["x"]).all()
    assert all((table[key][1:] == run[key]).all() for key in shown[1:])


@pytest.mark.parametrize(
    "name, what",
    [
        *((name, "ssp") for name in (*TOYS, *motion.EFFECTS) if name != "reference with state"),
        *((name, "modelica") for name in ("force on the body", "draws in each step")),
        *((name, "simulink") for name in ("force on the body", "draws in each step")),
    ],
)
def test_a_package_refuses_an_effect_by_its_name(name, what, tmp_path):
    stated = {**TOYS, **motion.EFFECTS}[name]
    calm = scenario_of("paper-simulation", {**SHORT, **stated, "disturbance.std": 0.0})
    law = {} if what == "modelica" else {"law": LAW}

    with pytest.raises(ArgumentError, match=rf"\[{next(iter(stated)).split('.')[0]}\]"):
        export_fmu(what, scenario=calm, out=tmp_path, **law)
    assert list(tmp_path.iterdir()) == []


def test_the_guard_refuses_an_effect_without_a_bound():
    with pytest.raises(ScenarioError, match=r"\[toy_ramp\]\) states no bound"):
        scenario_of("paper-simulation", TOYS["drive with state"], guard=True)
    with pytest.raises(ScenarioError, match=r"\[toy_ramp\]\) states no bound"):
        settle(scenario_of("paper-simulation", TOYS["drive with state"]), None)


def test_the_guard_adds_the_bound_of_an_effect():
    plain, steep = (
        settle(scenario_of("paper-simulation", {**SHORT, **more}, guard=True), LAW).guard
        for more in ({}, {"toy_slope.angle": 0.03, "toy_gyro.walk": 1e-4})
    )

    pull = 50.0 * 9.81 * np.sin(0.03)

    assert steep.dbar[0] == pytest.approx(plain.dbar[0] + pull)
    assert steep.dbar[1] == plain.dbar[1]
    assert steep.nbar == pytest.approx((0.0, 0.01))


def test_its_table_is_read_checked_and_written():
    scenario = paper_toml("[toy_slope]\nangle = 0.1\n")

    assert scenario.table("toy_slope").angle == 0.1
    assert loads_scenario(to_toml(scenario)).effects == scenario.effects
    assert "rise of the ground" in to_toml(scenario)
    with pytest.raises(UnknownKeyError, match=r"toy_slope\.angel"):
        paper_toml("[toy_slope]\nangel = 0.1\n")
    with pytest.raises(UnknownKeyError, match="toy_slop"):
        paper_toml("[toy_slop]\nangle = 0.1\n")
    with pytest.raises(ScenarioError, match=r"toy_slope\.angle = -1"):
        paper_toml("[toy_slope]\nangle = -1\n")


def test_a_stream_depends_on_its_name_alone():
    """An additional effect does not change the others' random numbers."""
    plain = simulate("paper-simulation", LAW, seed=3, overrides=SHORT)
    more = simulate("paper-simulation", LAW, seed=3, overrides={**SHORT, "toy_gyro.walk": 0.001})

    assert not np.array_equal(plain["x"], more["x"])
    assert np.array_equal(plain["noise_right"], more["noise_right"])


def test_only_what_acts_in_a_role_is_present():
    scenario = scenario_of("paper-simulation", {"gust.size": [1.0, 0.0]})

    pushing = {item.name for item in EFFECTS.present(scenario, EffectRole.DISTURBANCE)}
    assert "gust" in pushing
    assert "slope" not in pushing
    assert pushing < {item.name for item in EFFECTS.present(scenario)}
