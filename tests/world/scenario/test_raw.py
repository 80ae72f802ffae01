"""Overrides, as ``--set KEY=VALUE`` gives them."""

import math
from dataclasses import replace
from operator import attrgetter

import numpy as np
import pytest

from wmr_ctrl.core.errors import ScenarioError, UnknownNameError
from wmr_ctrl.world.references import Circle, Line
from wmr_ctrl.world.scenario import Change, load_scenario, override, parse_assignments
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
RESTING = Change(t=50.0, mu=0)


@pytest.mark.parametrize(
    "overrides, expected",
    [
        ({"robot.m": "60"}, {"robot.m": 60.0}),
        ({"robot.m": np.float64(60)}, {"robot.m": 60.0}),
        ({"robot": "{m = 60}"}, {"robot.m": 60.0, "robot.r": 0.1}),
        ({"limits.v_u2": np.array([0.7, 1.2])}, {"limits.v_u2": (0.7, 1.2)}),
        ({"limits.v_u2[1]": "0.7"}, {"limits.v_u2": (0.7, 1.3)}),
        ({"limits.v_u1": "2,2", "limits.v_u2": "1.5,1.5"}, {"limits.v_u2": (1.5, 1.5)}),
        ({"gains.mb.rho": "20,60"}, {"gains": {**PAPER.gains, "mb": {"rho": (20.0, 60.0)}}}),
        ({"changes": "[]"}, {"changes": ()}),
        ({"changes[1].m": "30"}, {"changes": (replace(PAPER.changes[0], m=30.0),)}),
        ({"changes[2].t": "50", "changes[2].mu": "0"}, {"changes": (*PAPER.changes, RESTING)}),
        ({"changes[2]": {"t": 50, "mu": 0}}, {"changes": (*PAPER.changes, RESTING)}),
        ({"changes[1].mu": "none"}, {"changes": (replace(PAPER.changes[0], mu=None),)}),
        ({"clock.duration": "10"}, {"changes": (), "clock.samples": 1000}),
        ({"clock.duration": "50"}, {"changes": PAPER.changes}),
        ({"reference.kind": "line"}, {"reference": Line(speed=0.5)}),
        ({"reference.speed": "1", "reference.kind": "line"}, {"reference": Line(speed=1)}),
        ({"reference.kind": "circle"}, {"reference": Circle(radius=2, rate=0.1)}),
        ({"reference.radius": "3"}, {"reference": Circle(radius=3, rate=0.1)}),
    ],
    ids=str,
)
def test_override_by_name_and_of_a_scenario_agree(overrides, expected):
    loaded = load_scenario("paper-simulation", overrides)

    assert {key: attrgetter(key)(loaded) for key in expected} == expected
    assert override(PAPER, overrides) == loaded


@pytest.mark.parametrize(
    "overrides, message",
    [
        ({"robot.mass": 3}, r"^robot\.mass is not a key in robot; near: m"),
        ({"limts.v_u1": 3}, r"^limts is not a key .*near: limits"),
        (
            {"limits.v_u2[3]": 3},
            r"^limits\.v_u2\[3\] does not exist: .*outside an array of 2 element",
        ),
        ({"limits.v_u2[0]": 3}, r"^limits\.v_u2\[0\] does not exist"),
        ({"changes[3].t": 3}, r"^changes\[3\]\.t does not exist"),
        ({"changes[1].t": 90}, r"^changes\[1\]\.t = 90\.0 s must be before the run's end"),
        ({"clock.duration": 10, "changes[1].m": 9}, r"^changes\[1\]\.t = 40\.0 s must be before"),
        ({"gains.nn.sigma[1]": 3}, r"^gains\.nn\.sigma\[1\] cannot be .*Give the whole array"),
        ({"robot.m.x": 3}, r"^robot\.m\.x does not exist"),
        ({"limits.v_u2": "1.6,1"}, r"^limits\.v_u2\[1\] = 1\.6 must be below limits\.v_u1\[1\]"),
        ({"reference.kind": "lin"}, r'^reference\.kind = "lin" is not a kind.*near: line'),
        ({"reference.file": "x.csv"}, r"^reference\.file is not a key in reference"),
        ({"extends": "far-start"}, r"^extends is not a key"),
        ({"gains.nn.sigma[2]": 3}, r"because gains\.nn\.sigma is not stated here"),
        ({"guard.dbar[1]": 3}, r"because guard\.dbar is not stated here. Give the whole array"),
        ({"robot.m[1]": 3}, r"robot\.m is 50\.0, which has no parts"),
        ({"changes[3].mu": 3}, r"index 3 is outside an array of 1"),
    ],
    ids=str,
)
def test_overrides_are_checked(overrides, message):
    for make, whole in ((load_scenario, "paper-simulation"), (override, PAPER)):
        with pytest.raises((ScenarioError, UnknownNameError), match=message):
            make(whole, overrides)
