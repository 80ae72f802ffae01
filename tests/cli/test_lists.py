"""`wmr-ctrl scenarios`, `laws` and `check`."""

import json
import re
import tomllib
from collections import Counter
from itertools import chain
from pathlib import Path

import pytest

from tests.commands import flat
from tests.tables import cases, changes
from wmr_ctrl.cli import check_answers
from wmr_ctrl.cli.check_sentences import REMEDIES, idle_keys, remedies, remedy
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.core.errors import CompilerError
from wmr_ctrl.results.remarks import SHORT
from wmr_ctrl.theory import checks
from wmr_ctrl.theory.checks.outlook import IN_PART, OF_THEORY
from wmr_ctrl.world.scenario import load_scenario, preset_names


def test_list_of_scenarios_as_json(wmr):
    """Each has a title; as text the list is as narrow as a terminal."""
    listed = json.loads(wmr("scenarios --json").stdout)
    found = wmr("scenarios").stdout

    assert all(f"{name} " in found for name in preset_names())
    assert max(map(len, found.splitlines())) <= 80
    assert [entry["name"] for entry in listed] == list(preset_names())
    assert all(entry["title"] for entry in listed)


@pytest.mark.parametrize("name", preset_names())
def test_printed_scenario_is_the_scenario(wmr, tmp_path, name):
    found = wmr(f"scenarios {name} --toml --complete")
    file = tmp_path / f"{name}.toml"
    file.write_text(found.stdout)
    printed, preset = scenario_of(file), scenario_of(name)

    assert found.exit_code == 0
    assert printed.gains.keys() == {"kinematics", *LAWS}
    for part in vars(preset):
        assert part == "gains" or getattr(printed, part) == getattr(preset, part)


@pytest.mark.parametrize("name", ["paper-simulation", "far-start-drop"])
def test_changes_are_left_out_of_a_file_to_edit(wmr, tmp_path, name):
    file = tmp_path / f"{name}.toml"
    file.write_text(wmr(f"scenarios {name} --toml").stdout)
    printed, preset = scenario_of(file), scenario_of(name)
    first = f"# changes at {preset.changes[0].t:g} s are left out; --complete writes them"

    assert file.read_text().startswith(f"{first}\n# guard.M_min and guard.M_max may cover")
    assert printed.changes == ()
    assert printed.title == f"{name}, changed"
    for part in vars(preset).keys() - {"gains", "changes", "title"}:
        assert getattr(printed, part) == getattr(preset, part)


def test_changes_that_are_asked_for_are_printed(wmr):
    found = wmr("scenarios", "safe-simulation", "--set", "changes=[{t = 9, m = 60}]").stdout

    assert tomllib.loads(found)["changes"] == [{"t": 9, "m": 60}]
    assert "left out;" not in found


def test_scenario_as_json(wmr):
    document = json.loads(wmr("scenarios far-start --set disturbance.truncate=inf --json").stdout)

    assert document["name"] == "far-start"
    assert document["initial"]["pose"] == [-5.0, -5.0, -0.7]
    assert document["disturbance"]["truncate"] is None


def test_laws(wmr):
    lines = wmr("laws").stdout.splitlines()

    assert [line.split()[0] for line in lines if not line.startswith(" ")] == list(LAWS)


def test_every_objection_and_remark_has_a_remedy():
    """Exceptions: objections to a law's own gains, and remarks that only narrow a promise."""
    objections = Path(checks.__file__).parent.glob("*.py")
    literal = (
        re.findall(r"[ (]Warning\(\s*\"([a-z._A-Z]+)\"", file.read_text()) for file in objections
    )
    keys = {*chain(*literal), *(set(SHORT) - {*IN_PART})} - {*OF_THEORY, "corridor-left"}

    assert len(keys) > 15
    assert keys <= set(REMEDIES)
    written = remedies(dict.fromkeys(keys, ""))
    assert all(len(line) <= 80 for text in written for line in text.splitlines())


def test_each_objection_is_shown_once_with_a_remedy():
    """Without --only; questions about units come before the guarantee."""
    changes = {"robot.m": 6000.0, "model.m": 80.0, "guard.enabled": True, "clock.duration": 1.0,
               "disturbance.std": 0.5, "encoder.counts": 1000.0}  # fmt: skip
    case = load_scenario("paper-simulation-nominal", changes)
    answers = check_answers.find_answers(case, ("mb", "pursuit"), (), None)
    text = flat("\n".join((*check_answers.head(answers), *check_answers.law_table(answers))))
    objections = {w for warned in answers.warned.values() for w in warned if w.objects}

    assert text.index("robot.m = 6000 kg is unusual") < text.index("Guarded")
    assert text.count("Set disturbance.truncate = 3 for a guarantee.") == 1
    assert {"robot.m", "guard.M_max"} <= {item.key for item in objections}
    for item in objections:
        assert item.sentence in text or f" {item.key}: {remedy(item.key)}" in text
    assert "see --only" not in text


@pytest.mark.parametrize(
    "asked, laws",
    [("--law pid,smc", None), ("", None), ("--law pid", ["pid"]), ("--corridor", ["kanayama"])],
)
def test_check_computes_corridors_where_they_are_asked_for(wmr, asked, laws):
    told = json.loads(wmr(f"{SHORT_BURGER} {asked} --json").stdout)

    assert (told["corridor"] and list(told["corridor"])) == laws
    assert list(told["verdict"]) == (asked.removeprefix("--law ").split(",") if "law" in asked
                                     else ["kanayama"])  # fmt: skip


SHORT_BURGER = "check turtlebot3-burger --set clock.duration=0.2"


def test_only_filter_lists_what_is_asked_of_its_numbers(monkeypatch):
    keys = ("filter", "filter.hold", "filterless", "guard", "guard.alpha")
    notes = [check_answers.Note(None, key, f"on {key}") for key in keys]
    monkeypatch.setattr(check_answers, "findings", lambda answers: iter(notes))
    assert [item.key for item in check_answers.about(None, "filter")] == ["filter", "filter.hold"]
    assert [item.key for item in check_answers.about(None, "guard")] == ["guard"]


def test_check_as_json(wmr):
    document = json.loads(wmr("check fast-reference --law mb --json").stdout)
    law = document["laws"]["mb"]

    assert document["valid"] is True
    assert document["max_period"] == {"mb": law["largest_stable_period"]}
    texts = [(item["key"], item["law"], item["text"]) for item in document["warnings"]]
    assert texts == [
        (w["key"], "mb", f"{w['sentence']} [{w['equation']}]") for w in law["warnings"]
    ]
    assert law["largest_stable_period"] == pytest.approx(0.061, rel=1e-2)
    assert {"key", "sentence", "equation", "objects"} == set(law["warnings"][0])
    assert document["verdict"] == {"mb": "objected"}
    assert "reference" in {warning["key"] for warning in law["warnings"]}


def test_check_without_a_compiler_says_so(wmr, monkeypatch):
    def missing(*_, **__):
        raise CompilerError("no C compiler was found.")

    monkeypatch.setattr("wmr_ctrl.api.simulate", missing)
    found = wmr("check paper-simulation-nominal --law mb --json")

    assert found.exit_code == 0
    assert json.loads(found.stdout)["nominal"] == {}
    assert "no law was run" in found.stderr


@pytest.mark.parametrize(
    "command",
    cases("""
    run safe-simulation --engine numpy --set clock.duration=0.2 | slow
    scenarios
    scenarios --reference waypoints
    laws
    """),
)
def test_no_width_loses_a_letter(wmr, monkeypatch, command):
    letters = Counter(filter(str.isalnum, wmr(command).stdout))
    for columns in ("20", "40", "60", "200"):
        monkeypatch.setenv("COLUMNS", columns)

        assert Counter(filter(str.isalnum, wmr(command).stdout)) == letters


@pytest.mark.parametrize("preset", preset_names())
def test_every_key_of_a_preset_does_something(preset):
    assert idle_keys(load_scenario(preset)) == ()


@pytest.mark.parametrize(
    "preset, idle, switch",
    cases("""
    paper-simulation | gyro.noise = 0.1 | gyro.enabled = true
    paper-simulation | slope.direction = 1.0 | slope.angle = 0.05
    paper-simulation | encoder.window = 0.02 | encoder.counts = 1024.0
    paper-simulation | actuator.lag_spread = 0.2 | actuator.lag = 0.02
    paper-simulation | base.tau = [0.3, 0.3] | base.kind = "velocity"
    paper-simulation | filter.gain = [0.9, 1.1] | base.kind = "velocity"
    turtlebot3-burger | base.kp = 9.0 | base.loop = "pi"; filter.kind = "none"
    turtlebot3-burger | guard.alpha = 3.0 | nothing
    """),
)
def test_keys_of_what_is_switched_off_are_told(preset, idle, switch):
    (key,) = stated = changes(idle)

    assert idle_keys(load_scenario(preset, stated)) == (key,)
    if switch != "nothing":
        assert key not in idle_keys(load_scenario(preset, stated | changes(switch)))


def test_check_tells_keys_without_effect(wmr):
    """Keys of presets are not reported: the Burger inherits a guard's masses without effect."""
    idle = "--set gyro.noise=0.1 --set metrics.rms_from=0.1 --set gains.mb.rho=9,9"
    short = f"check paper-simulation --law pid --set clock.duration=0.2 --set changes=[] {idle}"
    found, only = wmr(short), wmr(f"{short} --only corridor")
    preset = wmr(f"{SHORT_BURGER} --law pid")

    assert all("here: gyro.noise, gains.mb.rho." in item.stderr for item in (found, only))
    assert "guard.M_" not in preset.stdout + preset.stderr
