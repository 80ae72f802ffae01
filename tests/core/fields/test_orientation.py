"""`frames = "rep103"` measures orientations from +X at the interface, and changes no motion."""

import dataclasses
import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import wmr_ctrl
from tests.papers_robot import paper_toml
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.orientation import ORIENTATIONS, inward, outward
from wmr_ctrl.core.fields.section import quantities
from wmr_ctrl.report.scene import scene_of
from wmr_ctrl.results.compare import compare
from wmr_ctrl.world.scenario import (
    from_dict,
    load_scenario,
    loads_scenario,
    override,
    scenario_dict,
    to_toml,
)

angles = st.floats(-1e6, 1e6)
HEADED = """
frames = "rep103"
[initial]
pose = [0.5, -0.25, {yaw!r}]
[reference]
kind = "line"
heading = {heading!r}
[body]
uphill = {heading!r}
[clock]
duration = 1.0
"""


def headed(yaw=0.1, heading=0.3):
    return paper_toml(HEADED.format(yaw=yaw, heading=heading))


@given(angles)
def test_conversion_out_and_back_is_exact(yaw):
    inside = inward(yaw, "rep103")

    assert inward(outward(inside, "rep103"), "rep103") == inside
    assert outward(inside, "rep103") == pytest.approx(yaw, abs=2e-16 * (2 + abs(yaw)))


@given(angles, angles)
def test_a_scenario_survives_its_text(yaw, heading):
    scenario = headed(yaw, heading)

    assert from_dict(scenario_dict(scenario), scenario.name) == scenario
    assert loads_scenario(to_toml(scenario)) == scenario


def test_along_x_is_the_papers_minus_a_quarter_turn():
    scenario = headed(0.0, 0.0)

    assert scenario.initial.pose == (0.5, -0.25, -math.pi / 2)
    assert scenario.reference.heading == scenario.body.uphill == -math.pi / 2


def test_every_orientation_of_a_scenario_is_declared_and_no_other_angle():
    known = {**wmr_ctrl.world.scenario.scenario.sections(), "reference": type(headed().reference)}
    turned = {
        f"{key}.{name}" for key, part in known.items() for name, what in quantities(part)
        if what.orientation
    }  # fmt: skip

    assert turned == {"initial.pose", "reference.heading", "body.uphill"}
    for key, part in known.items():
        for name, what in quantities(part):
            assert ("0 along +Y" in what.doc) == (f"{key}.{name}" in turned), (key, name)


def test_a_file_may_use_other_frames_than_its_base(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text('extends = "paper-simulation"\nframes = "rep103"\n')
    over = tmp_path / "over.toml"
    over.write_text('extends = "mine.toml"\n[initial]\npose = [0, 0, 0]\n')

    assert load_scenario(file).initial == load_scenario("paper-simulation").initial
    assert load_scenario(over).initial.pose[2] == -math.pi / 2
    assert load_scenario(over).frames == "rep103"


def test_overrides_use_the_frames_that_result():
    paper = load_scenario("paper-simulation")
    turned = override(paper, {"frames": "rep103"})

    assert dataclasses.replace(turned, frames="paper") == override(paper, {"frames": "paper"})
    assert override(turned, {"initial.pose[3]": math.pi / 2}).initial.pose[2] == 0.0
    both = override(paper, {"frames": "rep103", "initial.pose[3]": 0.0})
    assert both.initial.pose[2] == -math.pi / 2


def test_the_text_states_its_frames():
    assert "theta is 0 along +X" in to_toml(headed())
    assert "+Y)" not in to_toml(headed()).partition("\n[")[2]
    assert "theta is 0 along +Y" in to_toml(load_scenario("paper-simulation"))


@pytest.mark.parametrize("frames", ["ros", 3, ["rep103"]])
def test_other_frames_are_refused(frames):
    with pytest.raises(ScenarioError, match=r"frames = .* is not known"):
        override(load_scenario("paper-simulation"), {"frames": frames})


@pytest.fixture(scope="module")
def both():
    scenario = override(headed(), {"sensor.pose_period": 0.1, "sensor.pose_noise": 0.01})
    paper = override(scenario, {"frames": "paper"})
    return tuple(wmr_ctrl.simulate(item, "mb", seed=2) for item in (scenario, paper))


@pytest.mark.slow
def test_a_run_is_the_same_motion_with_orientations_a_quarter_turn_on(both):
    turned, paper = both

    present = [name for name in ORIENTATIONS if name in paper]
    assert {"theta", "theta_d"} <= set(present)
    for signal in paper.signals:
        shift = math.pi / 2 if signal.name in present else 0.0
        assert np.array_equal(turned[signal.name], paper[signal.name] + shift), signal.name
    assert np.array_equal(turned["theta"], turned["psi"])
    assert "+X" in turned.signal("theta").meaning
    assert turned.summary()["ise"]["total"] == pytest.approx(paper.summary()["ise"]["total"])


@pytest.mark.parametrize("suffix", [".csv", ".npz"])
def test_a_saved_run_uses_the_frames_of_its_scenario(both, tmp_path, suffix):
    turned, _ = both
    turned.save(tmp_path / f"run{suffix}")

    loaded = wmr_ctrl.load_run(tmp_path / f"run{suffix}")
    assert loaded.settings.frames == "rep103"
    assert np.array_equal(loaded["theta"], turned["psi"])
    if suffix == ".csv":
        head, row = [
            line.split(",") for line in (tmp_path / "run.csv").read_text().splitlines()
            if not line.startswith("#")
        ][:2]  # fmt: skip
        assert float(row[head.index("theta [rad]")]) == pytest.approx(0.1, abs=1e-15)


def test_pictures_and_differences_do_not_depend_on_frames(both):
    scenes = [scene_of([run], 10) for run in both]

    for a, b in zip(scenes[0].actors[0].pose, scenes[1].actors[0].pose, strict=True):
        assert np.allclose(a, b, rtol=0, atol=1e-15)
    assert max(item.largest for item in compare(*both).columns) < 1e-15


@pytest.mark.slow
def test_starts_and_ends_of_many_runs_use_the_scenario_s_frames():
    turned = headed()
    paper = override(turned, {"frames": "paper"})
    start = [0.2, 0.1, 0.4, 0.0, 0.0]
    inside = [*start[:2], start[2] - math.pi / 2, *start[3:]]

    a = wmr_ctrl.simulate_many(turned, "mb", [0], starts=[start])
    b = wmr_ctrl.simulate_many(paper, "mb", [0], starts=[inside])
    assert a["final_theta"] == b["final_theta"] + math.pi / 2
    assert a["final_x"] == b["final_x"]


def test_a_notebook_shows_orientations_in_the_file_s_frames():
    yaw = paper_toml('frames = "rep103"\n[body]\nuphill = 0.25\n')
    shown = re.findall(r">body.uphill</td><td[^>]*>([^<]*)</td>", yaw._repr_html_())

    assert [float(text) for text in shown] == [pytest.approx(0.25)]
    assert yaw.body.uphill == pytest.approx(0.25 - math.pi / 2)
