"""Overrides, as ``--set KEY=VALUE`` gives them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.tables import cases, changes
from wmr_ctrl.core.errors import ScenarioError, UnknownNameError
from wmr_ctrl.world.scenario import load_scenario, loads_scenario, override, parse_assignments
from wmr_ctrl.world.scenario.raw import parse_key, parse_value


@pytest.mark.parametrize(
    "text, value",
    [
        ("1", 1),
        ("1e3", 1000.0),
        ("inf", math.inf),
        ("true", True),
        ("[1, 2]", [1, 2]),
        ("{a = 1}", {"a": 1}),
        ('"1"', "1"),
        ("1,2", [1, 2]),
        ("0.5 , 1e-3,", [0.5, 1e-3]),
        ("a,b", ["a", "b"]),
        ("circle", "circle"),
        ("two words", "two words"),
        ("1\nx = 2", "1\nx = 2"),
        ("", ""),
        (" 3 ", 3),
        (".95", 0.95),
        ("[-.5, 1.]", [-0.5, 1.0]),
        ("5.e-3, ./x.csv", [5e-3, "./x.csv"]),
    ],
)
def test_value_is_toml_or_a_list_or_a_word(text, value):
    assert parse_value(text) == value


def test_key_counts_from_one():
    assert parse_key("changes[2].mu") == ["changes", 1, "mu"]


@pytest.mark.parametrize(
    "key", ["", ".", "robot.", "robot..m", "a[", "a[1", "a[-1]", "a b", "a[x]"]
)
def test_bad_keys(key):
    with pytest.raises(ScenarioError, match="is not a key such as"):
        parse_key(key)


def test_assignments():
    assert parse_assignments(["a.b=1", "c = x=y", "a.b=2"]) == {"a.b": "2", "c": "x=y"}
    for text in ("a.b", "=3", ""):
        with pytest.raises(ScenarioError, match="is not KEY=VALUE"):
            parse_assignments([text])


PAPER = load_scenario("paper-simulation")
AGREE = """
    robot.m = 60 | robot.m = 60.0
    robot = {m = 60} | robot.m = 60.0
    limits.v_u2[1] = 0.7 | limits.v_u2 = [0.7, 1.3]
    limits.v_u1 = 2,2; limits.v_u2 = 1.5,1.5 | limits.v_u1 = [2, 2]; limits.v_u2 = [1.5, 1.5]
    gains.mb.rho = 20,60 | gains.mb.rho = [20.0, 60.0]
    changes = [] | changes = []
    changes[1].m = 30 | changes = [{FIRST, m = 30, mu = 0.15}]
    changes[1].mu = none | changes = [{FIRST, m = 65}]
    changes[2].t = 50; changes[2].mu = 0 | changes = [{FIRST, m = 65, mu = 0.15}, {t = 50, mu = 0}]
    changes[2] = {t = 50, mu = 0} | changes = [{FIRST, m = 65, mu = 0.15}, {t = 50, mu = 0}]
    clock.duration = 10 | clock.duration = 10; changes = []
    clock.duration = 50 | clock.duration = 50.0
    reference.kind = line | reference = {kind = "line", speed = 0.5}
    reference.speed = 1; reference.kind = line | reference = {kind = "line", speed = 1}
    reference.kind = circle | reference = {kind = "circle", radius = 2, rate = 0.1}
    reference.radius = 3 | reference = {kind = "circle", radius = 3, rate = 0.1}
"""


@pytest.mark.parametrize("text, toml", cases(AGREE))
def test_overrides_by_name_and_of_a_scenario_are_as_if_a_file_said_so(text, toml):
    lines = toml.replace("FIRST", "t = 40.0, I = 7.0").replace("; ", "\n")
    file = loads_scenario(f'extends = "paper-simulation"\n{lines}', PAPER.name)

    assert load_scenario("paper-simulation", changes(text)) == override(PAPER, changes(text))
    assert replace(override(PAPER, changes(text)), title="") == replace(file, title="")


def test_overrides_may_be_arrays():
    limits = override(PAPER, {"limits.v_u2": np.array([0.7, 1.2])}).limits

    assert limits.v_u2 == (0.7, 1.2)


REFUSED = r"""
    robot.mass = 3 | ^robot\.mass is not a key in robot; near: m
    limts.v_u1 = 3 | ^limts is not a key .*near: limits
    limits.v_u2[3] = 3 | ^limits\.v_u2\[3\] does not exist: .*outside an array of 2 element
    limits.v_u2[0] = 3 | ^limits\.v_u2\[0\] does not exist
    changes[3].t = 3 | ^changes\[3\]\.t does not exist
    changes[1].t = 90 | ^changes\[1\]\.t = 90\.0 s must be before the run's end
    clock.duration = 10; changes[1].m = 9 | ^changes\[1\]\.t = 40\.0 s must be before
    gains.nn.sigma[1] = 3 | ^gains\.nn\.sigma\[1\] cannot be .*Give the whole array
    robot.m.x = 3 | ^robot\.m\.x does not exist
    limits.v_u2 = 1.6,1 | ^limits\.v_u2\[1\] = 1\.6 must be below limits\.v_u1\[1\]
    reference.kind = lin | ^reference\.kind = "lin" is not a kind.*near: line
    reference.file = x.csv | ^reference\.file is not a key in reference
    extends = far-start | ^extends is not a key
    gains.nn.sigma[2] = 3 | because gains\.nn\.sigma is not stated here
    guard.dbar[1] = 3 | because guard\.dbar is not stated here. Give the whole array
    robot.m[1] = 3 | robot\.m is 50\.0, which has no parts
    changes[3].mu = 3 | index 3 is outside an array of 1
"""


@pytest.mark.parametrize("text, message", cases(REFUSED))
def test_overrides_are_checked(text, message):
    for make, whole in ((load_scenario, "paper-simulation"), (override, PAPER)):
        with pytest.raises((ScenarioError, UnknownNameError), match=message):
            make(whole, changes(text))
