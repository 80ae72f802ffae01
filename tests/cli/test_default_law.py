"""The default law: who states it, which messages mention it, whose gains are judged."""

import json
from dataclasses import replace

import pytest

from wmr_ctrl.control.given import default_law
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.checks import warnings_heard
from wmr_ctrl.world.scenario import load_scenario, override, preset_names

SHORT = ("--set", "clock.duration=0.2")
NOISY = {"encoder.counts": 16.0, "gains.kinematics.k": [10.0, 5.0, 4.0]}
"""Noise for which every law's gains cause objections."""


@pytest.mark.parametrize("name", preset_names())
def test_presets_of_the_paper_drive_with_its_law_and_others_have_one_without_a_network(name):
    assert (default_law(load_scenario(name)).name == "nn") is name.startswith("paper")


@pytest.mark.parametrize("law, why", [(None, "not stated"), ("mb", "stated in the scenario")])
def test_a_run_without_law_says_which_it_takes_and_why(wmr, law, why, tmp_path):
    file = tmp_path / "mine.toml"
    text = 'extends = "turtlebot3-burger"\n'
    file.write_text((f'law = "{law}"\n' if law else "") + text)
    named = default_law(load_scenario(str(file)))
    found = wmr("run", str(file), *SHORT, "--engine", "numpy", "--json")

    assert json.loads(found.stdout)["law"] == named.name == (law or "kanayama")
    if law or not named.stated:
        assert f"law {named.name}: {why}\n" in found.stderr


def test_gains_that_nobody_chose_are_not_objected_to():
    plain = load_scenario("paper-simulation-nominal", {"law": "kanayama", **NOISY})
    others = {law: gains for law, gains in plain.gains.items() if law != "kanayama"}
    plain = replace(plain, gains=others)
    unstated = override(plain, {"law": None})
    stated = override(unstated, {"gains.kanayama.wo": 5.0})

    def objected(scenario, law, asked):
        keys = [item.key for item in warnings_heard(settle(scenario, law), asked)]
        return any(key.startswith("gains.") for key in keys)

    assert objected(plain, "kanayama", False)
    assert objected(unstated, "kanayama", True)
    assert not objected(unstated, "kanayama", False)
    assert objected(stated, "kanayama", False)
    assert not objected(plain, "mb", False)
    assert objected(plain, "mb", True)
