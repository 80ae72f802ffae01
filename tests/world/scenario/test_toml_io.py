"""Scenarios as TOML: files of users, ``extends``, and text that loads back equal."""

import math
import pickle

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.papers_robot import HEAD, paper, paper_toml
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.section import quantities
from wmr_ctrl.world.references import Circle, Line
from wmr_ctrl.world.scenario import (
    Change,
    from_dict,
    load_scenario,
    loads_scenario,
    override,
    preset_titles,
    scenario_dict,
    title_of,
    to_toml,
)
from wmr_ctrl.world.scenario.scenario import SECTIONS

FULL = """
title = "odd \\"title\\" with = and # and é"
robot = {m = 63.25, I = 5.4, mu = 0.08, r = 0.1, l = 0.25, v_s = 1e-300}
model = {mu = 0.0, I = 0.3333333333333333}
disturbance = {std = 0.30000000000000004, truncate = 3.0}
sensor = {pose_period = 0.02, pose_noise = 0.01, velocity_noise = [0.1, 0.2], correction = 0.5}
actuator = {tau_max = 20.0, lag = 0.02, delay = 0.003}
changes = [{t = 1.0, m = 3.0}, {t = 2.0, I = 4.0, mu = 0.0}]
clock = {control = 0.02, plant = 0.001, duration = 4.0}
metrics = {split = 1.5, rms_from = 0.0}
gains.mb = {rho = [1.0, 2.0]}
gains.nn = {on = false, way = "x", eta = 3.141592653589793}
gains.pid = {}
"""
MOTIONS = """
kind = "circle", radius = 3.0, rate = -0.2
kind = "line", speed = 0.1, heading = 0.3, origin = [1.0, 2.0]
kind = "lemniscate", size = 1.0, rate = 0.2
kind = "rounded-square", side = 2.0, corner = 0.5, speed = 0.1
kind = "stop-and-go", radius = 1.0, speed = 0.2, period = 4.0
kind = "waypoints", points = [[0.1, 0.2], [1.0, 0.5], [1.5, 2.0]], closed = true, v_max = 0.4
"""


@pytest.mark.parametrize("reference", MOTIONS.strip().splitlines())
@pytest.mark.parametrize("comments", [True, False])
def test_every_kind_and_field_loads_back_equal(reference, comments):
    scenario = paper_toml(f"{FULL}reference = {{{reference}}}")

    assert loads_scenario(to_toml(scenario, comments), scenario.name) == scenario
    assert from_dict(scenario_dict(scenario), scenario.name) == scenario
    assert scenario.gains["nn"]["eta"] == math.pi


@pytest.mark.parametrize("name", preset_titles())
def test_a_preset_loads_back_equal_from_any_text_and_copy(name):
    scenario = load_scenario(name)
    whole, short = to_toml(scenario), to_toml(scenario, only={"robot.m"})

    assert loads_scenario(whole, name) == loads_scenario(short, name) == scenario
    assert len(short) < len(whole) / 2
    copy = pickle.loads(pickle.dumps(scenario))
    assert copy == scenario
    assert hash(copy) == hash(scenario)


finite = st.floats(-1e12, 1e12)
values = st.one_of(finite, st.booleans(), st.text(max_size=8), st.tuples(finite, finite))
words = st.text(max_size=5)
gains = st.dictionaries(words, st.dictionaries(words, values, max_size=2), max_size=2)


@settings(max_examples=20)
@given(gains, finite, st.text(max_size=20))
def test_any_gains_numbers_and_titles_load_back_equal(gains, heading, title):
    scenario = paper(title=title, gains=gains, reference=Line(heading=heading))

    assert loads_scenario(to_toml(scenario), scenario.name) == scenario


def test_every_field_is_printed_with_unit_and_meaning():
    text = to_toml(load_scenario("paper-simulation-no-switch"))

    for cls in (*SECTIONS.values(), Circle, Change):
        for name, what in quantities(cls):
            assert any(
                name in line and f"[{what.unit}] {what.doc}" in line for line in text.splitlines()
            )
    assert "#" not in to_toml(paper(), comments=False)


def test_gains_are_printed_with_their_meaning():
    docs = {
        "mb": {"rho": ((15.0, 57.6), "1/s", "decay rates")},
        "nn": {"eta": (1.5, "1", "width"), "integrator": ("explicit", "", "update of the weights")},
    }
    scenario = paper(gains={"mb": {"rho": (1.0, 2.0)}, "mine": {"k": 3.0}})
    text = to_toml(scenario, gains_docs=docs)

    assert "rho = [1.0, 2.0] # [1/s] decay rates" in text
    assert "eta = 1.5 # [1] width" in text
    assert paper_toml(text).gains == {
        "mb": {"rho": (1.0, 2.0)},
        "nn": {"eta": 1.5, "integrator": "explicit"},
        "mine": {"k": 3.0},
    }


def test_file_of_a_user_extends_a_preset(tmp_path):
    file = tmp_path / "heavier.toml"
    file.write_text('extends = "paper-simulation"\n[robot]\nm = 70.0\n', encoding="utf-8-sig")
    scenario = load_scenario(str(file))

    assert scenario.name == "heavier"
    assert (scenario.robot.m, scenario.robot.I) == (70.0, 5.4)
    assert scenario.changes == load_scenario("paper-simulation").changes


def test_files_extend_files_next_to_them(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "way.csv").write_text("x,y\n0,0\n1,0\n2,1\n")
    (tmp_path / "base.toml").write_text(
        f'title = "base"\n{HEAD}[reference]\nkind = "waypoints"\nfile = "way.csv"\n'
        "[robot]\nm = 60.0\n"
    )
    (tmp_path / "sub" / "child.toml").write_text('extends = "../base.toml"\n[robot]\nI = 6.0\n')
    scenario = load_scenario(tmp_path / "sub" / "child.toml")

    assert scenario.reference.points == ((0, 0), (1, 0), (2, 1))
    assert (scenario.robot.m, scenario.robot.I) == (60.0, 6.0)
    assert scenario.title == "base"


def test_points_of_a_file_that_is_extended_take_the_place_of_the_other(tmp_path):
    files = {
        "way.csv": "0,0\n1,0\n2,1\n",
        "base.toml": f'{HEAD}[reference]\nkind = "waypoints"\nfile = "way.csv"\n',
        "points.toml": 'extends = "base.toml"\nreference.points = [[0, 0], [3, 0]]\n',
        "back.toml": 'extends = "points.toml"\nreference.file = "way.csv"\n',
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text)

    base, points, back = (
        load_scenario(tmp_path / name).reference.points for name in files if name != "way.csv"
    )

    assert points == ((0.0, 0.0), (3.0, 0.0))
    assert back == base == ((0.0, 0.0), (1.0, 0.0), (2.0, 1.0))


def test_a_preset_s_title_is_shown_only_for_its_own_numbers(tmp_path):
    file = tmp_path / "mine.toml"
    quiet = {"disturbance.std": 0.0}
    for name in ("paper-simulation", "far-start"):
        file.write_text(f'extends = "{name}"')
        own, title = load_scenario(name), f"{name}, changed"

        assert title_of(own) == title_of(load_scenario(file)) == preset_titles()[name]
        assert title_of(load_scenario(name, quiet)) == title_of(override(own, quiet)) == title
        assert title_of(load_scenario(file, quiet)) == title
        assert title_of(load_scenario(file, {**quiet, "title": "Mine"})) == "Mine"
    assert title_of(paper_toml("")) == ""


def test_a_preset_wins_over_a_file_of_its_name(tmp_path, monkeypatch):
    (tmp_path / "far-start").write_text('title = "mine"')
    monkeypatch.chdir(tmp_path)

    assert load_scenario("far-start").title != "mine"
    with pytest.raises(ScenarioError, match=r"must end in \.toml"):
        load_scenario("./far-start")


def test_a_study_plan_is_recognised(tmp_path):
    plan = tmp_path / "plan.toml"
    plan.write_text('scenario = "far-start"\nlaws = ["mb"]\nseeds = 4\n', encoding="utf-8")

    with pytest.raises(
        ScenarioError, match=r"plan\.toml is a study plan, not a scenario.*wmr-ctrl study"
    ):
        load_scenario(plan)
