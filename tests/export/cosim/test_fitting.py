"""Parts of a scenario that FMUs cannot provide are refused, also those fixed by drives and
clocks.
"""

import ctypes as ct
import re

import numpy as np
import pytest

from tests.commands import flat
from tests.export.cosim.foreign import LOST, PLANT_MAP
from tests.export.cosim.test_run import SHORT
from tests.papers_robot import preset
from tests.tables import cases, changes
from wmr_ctrl.api import simulate
from wmr_ctrl.cli.summary import summary_text
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.export.cosim import cosimulate
from wmr_ctrl.export.cosim.fitting import law_within
from wmr_ctrl.export.cosim.slave import Slave
from wmr_ctrl.export.fmi.closed_loop import closed_loop_model
from wmr_ctrl.export.fmi.ssp import export_ssp
from wmr_ctrl.world.scenario import load_scenario, override

OTHER_STRUCTURES = cases("""
    actuator.lag = 0.02
    gains.nn.regressor = "q" | slow
    gains.nn.barrier = "smooth" | slow
    actuator.delay = 0.003 | slow
""")


@pytest.mark.parametrize("changed", OTHER_STRUCTURES)
def test_a_controller_of_another_structure_is_refused(exported, changed):
    with pytest.raises(ArgumentError, match="more than numbers"):
        cosimulate(override(SHORT, changes(changed)), "nn", controller=exported("nn", 2))


def test_a_controller_of_another_law_or_without_a_map_is_refused(exported, their_controller):
    with pytest.raises(ArgumentError, match="not the mb of this scenario"):
        cosimulate(SHORT, "mb", controller=exported("nn", 2))
    with pytest.raises(ArgumentError, match="is not one of ours"):
        cosimulate(SHORT, controller=their_controller["controller"])
    with pytest.raises(ArgumentError, match=r"'pid' has no effect: the controller .*Leave"):
        cosimulate(SHORT, "pid", **their_controller)


@pytest.mark.parametrize("key", ["base.rest", "filter.free_error"])
def test_what_no_part_does_is_refused_before_any_is_built(key, monkeypatch):
    monkeypatch.delattr("wmr_ctrl.export.cosim.run.write_fmu")
    cart = """
        base.kind = velocity
        limits.v_u1 = [1, 2]
        filter.kind = governor
        filter.tau = [0.1, 0.3]
        filter.rest = 1
        disturbance.std = 0
    """
    with pytest.raises(ArgumentError, match=key):
        cosimulate(preset("paper-simulation", cart, {key: 0.5}), "kanayama")


def test_a_step_that_does_not_divide_the_period_is_refused(their_plant, mapped):
    """Otherwise it would be rounded silently."""
    given = their_plant | {"map_file": mapped(PLANT_MAP.replace("0.005", "0.003"))}
    with pytest.raises(ArgumentError, match=r"0\.003 s, does not divide .* Take 0\.00333333333 s"):
        cosimulate(SHORT, "pid", **given)


def test_drives_limit_a_foreign_controller(their_controller):
    run, free = (
        cosimulate(override(SHORT, {"actuator.tau_max": most, "clock.duration": 0.5}),
                   **their_controller)
        for most in (4.5, np.inf)
    )  # fmt: skip
    assert np.abs(run["tau_right"]).max() == pytest.approx(4.5, rel=1e-12)
    assert np.abs(free["tau_right"]).max() > 20.0
    assert run.law == "TheirController"
    assert "controller: TheirController (TheirController.fmu" in summary_text(run)
    assert np.isnan(run["V1"]).all()


@pytest.mark.parametrize("changed", [{"disturbance.std": 1.0}, {"disturbance.push": [3.0, 0.0]}])
def test_a_disturbance_that_a_map_leaves_out_is_refused(their_plant, mapped, changed):
    given = their_plant | {"map_file": mapped(PLANT_MAP.replace("torque_", "tau_"))}
    with pytest.raises(ArgumentError, match="does not reach"):
        cosimulate(override(SHORT, changed), "pid", **given)


def test_a_foreign_plant_starts_where_the_scenario_does(their_plant):
    elsewhere = override(SHORT, {"initial.pose": [-0.5, 0.25, -0.7]})
    with pytest.raises(ArgumentError, match=r"y = -0\.5, not 0\.25"):
        cosimulate(elsewhere, "pid", **their_plant)


def test_a_foreign_plant_is_watched_at_its_own_steps(their_plant):
    """Twice in a control period at 5 ms, as the map says."""
    slow = override(SHORT, {"clock.duration": 0.5, "limits.v_u1": [1e-9, 1e-9],
                            "limits.v_u2": [1e-10, 1e-10], "limits.clip": 1e-11})  # fmt: skip
    run = cosimulate(slow, "pid", **their_plant)
    text = flat(summary_text(run))
    assert run.monitor.violations == 2 * run.rows
    assert (run.settings.plant, run.settings.plant_kind) == (0.005, "fmu")
    assert "watched every 0.005 s" in text
    assert "100 plant steps of 0.005 s" in text
    assert np.abs(run["x"] - simulate(slow, "pid")["x"]).max() < 2e-3
    told = r"TheirRobot \(TheirRobot\.fmu, FMI 2\.0, sha256 [0-9a-f]{16}\)"
    assert re.fullmatch(told, run.provenance["fmu_plant"])


@pytest.mark.parametrize(
    "changed, match",
    [
        ({"actuator.lag": 0.02}, r"0\.005 s, does not divide clock\.plant = 0\.001 s"),
        ({"changes": [{"t": 0.013, "m": 55.0}]}, r"t = 0\.013 s falls between two steps"),
    ],
)
def test_a_plant_is_stepped_by_its_maps_step_or_not_at_all(their_plant, mapped, changed, match):
    mass = '{ terms = { motorR = 1.0 }, unit = "kg" }'
    text = f'{PLANT_MAP}[plant.parameters]\n"robot.m" = {mass}\n'
    with pytest.raises(ArgumentError, match=match):
        cosimulate(override(SHORT, changed), "pid", **their_plant | {"map_file": mapped(text)})


def test_a_plant_that_gives_no_numbers_is_named(foreign, mapped):
    given = {"plant": foreign("TheirLoss", LOST), "map_file": mapped(PLANT_MAP)}
    run = cosimulate(override(SHORT, {"clock.duration": 1.0}), "pid", **given)
    said = "TheirLoss.fmu (plant) failed at t = 0.495 s in its outputs, which give"
    assert run.outcome == "failed"
    assert said in run.explanation
    assert ": kept until it ended" in flat(summary_text(run))


def test_messages_of_fmi_2_have_their_values(exported, tmp_path):
    """A model may leave it to the importer to insert values into the text, each message its own."""
    slaves = [Slave(exported("nn", 2), name, tmp_path / name) for name in ("first", "second")]
    texts = ct.c_char_p, ct.c_int, ct.c_char_p, ct.c_char_p, ct.c_int
    kind = ct.CFUNCTYPE(None, ct.c_void_p, *texts)
    for size, slave in enumerate(slaves):
        told = slave._callbacks
        log = ct.cast(told.logger, kind)
        log(told.componentEnvironment, b"i", 3, b"c", b"a step of %d s", size)
        assert [*slave.messages] == [f"a step of {size} s"]
    for slave in slaves:
        slave.end()


@pytest.mark.parametrize(
    "changed, said",
    cases("""
        disturbance.push = [3.0, 0.0] | push
        sensor.pose_noise = 0.01 | pose sensor
        sensor.velocity_noise = [0.0, 0.01] | velocity noise
        actuator.lag = 0.02 | lag
        actuator.delay = 0.003 | delay
    """),
)
def test_a_package_that_would_lose_a_part_is_refused(tmp_path, changed, said):
    with pytest.raises(ArgumentError, match=said):
        export_ssp(scenario=override(SHORT, changes(changed)), out=tmp_path)


def test_drives_that_the_controller_is_built_for_are_fixed():
    tries = (("actuator.lag", 0.0), ("actuator.delay", 0.0), ("clock.plant", 0.0005),
             ("actuator.lag", 0.03), ("actuator.delay", 0.003))  # fmt: skip
    late = {"actuator.delay": 0.003, "actuator.lag": 0.02}
    for drives, taken in (({}, tries[:3]), (late, tries[3:])):
        model = closed_loop_model(settle(load_scenario("paper-simulation", drives), "mb"))
        ends = {v.name: (v.low, v.high) for v in model.variables}
        for name, value in tries:
            low, high = ends[name]
            assert (low <= value <= high) == ((name, value) in taken)


def test_the_law_within_one_of_our_controllers_is_known(exported, tmp_path):
    (tmp_path / "no.fmu").write_text("no archive")

    assert law_within(exported("nn", 3)) == "nn"
    assert law_within(exported("plant", 3)) is None
    assert law_within(tmp_path / "no.fmu") is None
    assert law_within(None) is None
