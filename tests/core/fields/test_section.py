"""Fields with unit, meaning and bounds, as scenarios and laws use them."""

from __future__ import annotations

import math
import re
import tomllib
from dataclasses import FrozenInstanceError, fields

import numpy as np
import pytest

from tests.papers_robot import paper
from tests.tables import cases
from wmr_ctrl.core.errors import ScenarioError, UnknownKeyError, UnknownNameError
from wmr_ctrl.core.fields.section import Section, build, quantity
from wmr_ctrl.core.fields.values import Frozen
from wmr_ctrl.world.references import REFERENCES
from wmr_ctrl.world.scenario import Change, Robot, Scenario
from wmr_ctrl.world.scenario.scenario import SECTIONS
from wmr_ctrl.world.scenario.sections import Limits

KINDS = [kind.section for kind in REFERENCES.values()]


class Gains(Section, key="gains.toy"):
    """Gains as a law would have them."""

    rho: tuple[float, float] = quantity((15.0, 57.6), unit="1/s", doc="rates", above=0)
    nodes: int = quantity(64, unit="1", doc="number of nodes", minimum=1, maximum=1000)
    method: str = quantity("explicit", unit="", doc="update", options=("explicit", "implicit"))
    leak: bool = quantity(True, unit="", doc="whether the weights leak")
    cap: float = quantity(1e3, unit="1", doc="cap", above=0, infinite=True)
    share: float = quantity(0.5, unit="1", doc="share", minimum=0, below=1)


@pytest.mark.parametrize("cls", [*SECTIONS.values(), *KINDS, Change, Gains])
def test_every_field_has_unit_meaning_and_bounds(cls):
    for field in fields(cls):
        assert field.metadata["doc"]
        assert "\n" not in field.metadata["doc"]
        assert isinstance(field.metadata["unit"], str)
        assert field.metadata["bounds"] is not None


def test_values_take_the_type_of_the_default():
    gains = build(Gains, {"rho": [1, 2], "nodes": 8.0, "cap": math.inf, "leak": False})

    assert gains.rho == (1.0, 2.0)
    assert type(gains.rho[0]) is float
    assert type(gains.nodes) is int
    assert gains == Gains(rho=np.array([1, 2]), nodes=8, cap=np.inf, leak=False)
    with pytest.raises(FrozenInstanceError):
        gains.nodes = 9


WRONG = """
    rho = [1.0] | gains.toy.rho = [1.0] must be an array of 2 numbers
    rho = 1.0 | gains.toy.rho = 1.0 must be an array of 2 numbers
    rho = "ab" | gains.toy.rho = "ab" must be an array of 2 numbers
    rho = [1.0, 0.0] | gains.toy.rho[2] = 0.0 must be above 0
    rho = [true, 1.0] | gains.toy.rho[1] = true must be a number
    nodes = 1.5 | gains.toy.nodes = 1.5 must be a whole number
    nodes = 0 | gains.toy.nodes = 0 must be at least 1
    nodes = 2000 | gains.toy.nodes = 2000 must be at most 1000
    method = "explict" | gains.toy.method = "explict" is not known (update); near: explicit
    method = 3 | gains.toy.method = 3 must be text
    leak = 1 | gains.toy.leak = 1 must be true or false
    cap = nan | gains.toy.cap = nan must be a finite number
    cap = -inf | gains.toy.cap = -inf must be above 0
    share = 1.0 | gains.toy.share = 1.0 must be below 1
"""


@pytest.mark.parametrize("toml, message", cases(WRONG))
def test_errors_start_with_the_key_and_tell_the_rule(toml, message):
    values = tomllib.loads(toml)
    for make in (lambda: build(Gains, values), lambda: Gains(**values)):
        with pytest.raises(ScenarioError) as caught:
            make()
        assert str(caught.value).startswith(message)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "value, message",
    [(None, "None must be a number"), (10**400, "an integer beyond 1e30 must be at most 1e+12")],
)
def test_values_that_no_file_has_are_told_too(value, message):
    with pytest.raises(ScenarioError, match=re.escape(f"gains.toy.share = {message}")):
        build(Gains, {"share": value})


def test_unknown_keys_are_both_kinds_of_error():
    with pytest.raises(
        UnknownKeyError, match=r"^gains\.toy\.roh is not a key .*near: rho"
    ) as caught:
        build(Gains, {"roh": [1, 2]})
    assert isinstance(caught.value, ScenarioError)
    assert isinstance(caught.value, UnknownNameError)


def test_required_field():
    with pytest.raises(
        ScenarioError, match=r"^changes\[3\]\.t is missing: time of the change \[s\]"
    ):
        build(Change, {"m": 3.0}, "changes[3]")


def test_scenario_made_in_python_is_checked_and_frozen():
    scenario = paper(
        robot=Robot(m=60, I=5.4, mu=0.0, r=0.1, l=0.2),
        gains={"mb": {"rho": [15, 57.6], "on": True, "x": "y"}},
    )

    assert scenario.gains == {"mb": {"rho": (15.0, 57.6), "on": True, "x": "y"}}
    assert type(scenario.robot.m) is float
    assert isinstance(hash(scenario), int)
    with pytest.raises(TypeError):
        scenario.gains["mb"] = {}
    with pytest.raises(ScenarioError, match=r"^limits"):
        Scenario(limits=Robot())
    with pytest.raises(ScenarioError, match=r"^changes"):
        paper(changes=(3,))
    with pytest.raises(ScenarioError, match=r"^reference"):
        paper(reference=Limits())


def test_frozen_mapping():
    table = Frozen({"a": 1, "b": 2})

    assert table == {"b": 2, "a": 1}
    assert hash(table) == hash(Frozen({"b": 2, "a": 1}))
    assert "a" in repr(table)
