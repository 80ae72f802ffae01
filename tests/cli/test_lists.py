"""`wmr-ctrl scenarios`, `laws` and `check`."""

import json
import re
import tomllib
from collections import Counter
from itertools import chain
from pathlib import Path

import pytest

from wmr_ctrl.cli import check_answers
from wmr_ctrl.cli.check_sentences import REMEDIES, idle_keys, remedies, remedy
from wmr_ctrl.control.default_law import default_law
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.core.errors import CompilerError
from wmr_ctrl.results.remarks import SHORT
from wmr_ctrl.theory import checks
from wmr_ctrl.theory.checks.outlook import IN_PART, OF_THEORY
from wmr_ctrl.world.scenario import load_scenario, preset_names


def test_every_scenario_is_listed_with_its_title(wmr):
    found = wmr("scenarios").stdout

    assert all(f"{name} " in found for name in preset_names())
    assert max(map(len, found.splitlines())) <= 80


def test_list_of_scenarios_as_json(wmr):
    listed = json.loads(wmr("scenarios --json").stdout)

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


def test_printed_scenario_explains_every_number(wmr):
    lines = wmr("scenarios paper-simulation").stdout.splitlines()
    numbers = [line for line in lines if " = " in line and not line.startswith(("#", "title"))]

    assert len(numbers) > 40
    assert all("# " in line for line in numbers)


def test_overrides_reach_the_printed_scenario(wmr):
    found = wmr("scenarios far-start --set robot.m=77").stdout

    assert tomllib.loads(found)["robot"]["m"] == 77


def test_scenario_as_json(wmr):
    document = json.loads(wmr("scenarios far-start --set disturbance.truncate=inf --json").stdout)

    assert document["name"] == "far-start"
    assert document["initial"]["pose"] == [-5.0, -5.0, -0.7]
    assert document["disturbance"]["truncate"] is None


def test_laws(wmr):
    lines = wmr("laws").stdout.splitlines()

    assert [line.split()[0] for line in lines if not line.startswith(" ")] == list(LAWS)


def test_laws_as_json(wmr):
    listed = json.loads(wmr("laws --json").stdout)

    assert [entry["name"] for entry in listed] == list(LAWS)


@pytest.mark.slow
def test_check_answers_first_and_on_one_screen(wmr):
    found = wmr("check paper-experiment-literal --law all")
    lines = found.stdout.splitlines()
    promised, _, table = found.stdout.partition("\n\n")

    assert found.exit_code == 0
    assert found.stdout.startswith("paper-experiment-literal is valid")
    assert "Not guarded: |v1| <= 1 m/s and |omega| <= 1.5 rad/s are not guaranteed" in flat(
        promised
    )
    rows = table.partition("─\n")[2].partition("\n\n")[0].splitlines()
    assert [row.split()[0] for row in rows if not row.startswith(" ")] == list(LAWS)
    assert len(lines) < 40
    assert "  gains.nn.eta: lower gains.nn.eta, or raise gains.nn.rho1" in lines
    assert max(map(len, lines)) <= 80


def test_every_objection_and_remark_has_a_remedy():
    """But for those of a law's own gains, and for remarks that only narrow a promise."""
    objections = Path(checks.__file__).parent.glob("*.py")
    literal = (
        re.findall(r"[ (]Warning\(\s*\"([a-z._A-Z]+)\"", file.read_text()) for file in objections
    )
    keys = {*chain(*literal), *(set(SHORT) - {*IN_PART})} - {*OF_THEORY, "corridor-left"}

    assert len(keys) > 15
    assert keys <= set(REMEDIES)
    written = remedies(dict.fromkeys(keys, ""))
    assert all(len(line) <= 80 for text in written for line in text.splitlines())


@pytest.mark.parametrize("laws", [("mb",), ("mb", "pursuit")])
def test_each_objection_is_shown_once_with_a_remedy(laws):
    """Without --only; what looks like another unit comes before the guarantee."""
    changes = {"robot.m": 6000.0, "model.m": 80.0, "guard.enabled": True, "clock.duration": 1.0,
               "disturbance.std": 0.5, "encoder.counts": 1000.0}  # fmt: skip
    case = load_scenario("paper-simulation-nominal", changes)
    answers = check_answers.find_answers(case, laws, (), None)
    text = flat("\n".join((*check_answers.head(answers), *check_answers.law_table(answers))))
    objections = {w for law in laws for w in answers.warned[law] if w.objects}

    assert text.index("robot.m = 6000 kg is unusual") < text.index("Guarded")
    assert text.count("Set disturbance.truncate = 3 for a guarantee.") == 1
    assert {"robot.m", "guard.M_max"} <= {item.key for item in objections}
    for item in objections:
        assert item.sentence in text or f" {item.key}: {remedy(item.key)}" in text
    assert "see --only" not in text


def test_check_judges_the_scenarios_own_law(wmr):
    document = json.loads(wmr("check", *SHORT_BURGER, "--json").stdout)
    law = default_law(load_scenario("turtlebot3-burger")).name

    assert list(document["verdict"]) == [law]
    both = json.loads(wmr("check", *SHORT_BURGER, "--law", "pid,smc", "--json").stdout)
    assert list(both["verdict"]) == ["pid", "smc"]


@pytest.mark.parametrize(
    "asked, laws",
    [
        (("--law", "pid,smc"), None),
        ((), None),
        (("--law", "pid"), ["pid"]),
        (("--law", "pid,smc", "--corridor"), ["pid", "smc"]),
        (("--corridor",), ["kanayama"]),
    ],
)
def test_check_computes_corridors_where_they_are_asked_for(wmr, asked, laws):
    found = json.loads(wmr("check", *SHORT_BURGER, *asked, "--json").stdout)["corridor"]

    assert (found and list(found)) == laws


SHORT_BURGER = ("turtlebot3-burger", "--set", "clock.duration=0.2")


def flat(text):
    return " ".join(text.split())


@pytest.mark.slow
def test_check_says_why_the_guard_would_be_refused(wmr):
    weak = ("--set", "actuator.tau_max=1", "--set", "clock.duration=2", "--law", "kanayama")

    said = flat(wmr("check", "safe-simulation", "--no-guard", *weak).stdout)
    assert "--guard is refused: guard: the wheels cannot hold the robot" in said


@pytest.mark.slow
def test_check_has_every_finding_by_its_name(wmr, monkeypatch):
    """What is found of the same laws is worked out once: asked is how it is told."""
    find, found = check_answers.find_answers, {}

    def once(case, laws, taken, *alone, **more):
        key = (*laws, *alone, *more.items())
        return (
            found[key]
            if key in found
            else found.setdefault(key, find(case, laws, taken, *alone, **more))
        )

    monkeypatch.setattr(check_answers, "find_answers", once)
    some = ("check", "paper-simulation", "--law", "pid,smc,nn", "--corridor")
    document = json.loads(wmr(*some, "--json").stdout)
    keys = {"stability", "run", "corridor"} | {item["key"] for item in document["warnings"]}
    every = wmr(*some, "-v").stdout

    assert {"gains.nn.eta", "disturbance.std", "law"} < keys
    for name in (*keys, "limit-violated", "nn"):
        told = wmr(*some, "--only", name).stdout
        assert told.count("  - ") >= 1
        assert set(told.splitlines()) <= set(every.splitlines())
    assert "--only 'gains.mb.eta' is not among the findings: pid, smc," in flat(
        wmr(*some, "--only", "gains.mb.eta").stderr
    )


def test_only_filter_lists_what_is_asked_of_its_numbers(monkeypatch):
    keys = ("filter", "filter.hold", "filterless", "guard", "guard.alpha")
    notes = [check_answers.Note(None, key, f"on {key}") for key in keys]
    monkeypatch.setattr(check_answers, "findings", lambda answers: iter(notes))
    assert [item.key for item in check_answers.about(None, "filter")] == ["filter", "filter.hold"]
    assert [item.key for item in check_answers.about(None, "guard")] == ["guard"]


@pytest.mark.slow
def test_check_of_one_law_without_objection(wmr):
    found = wmr("check paper-simulation-nominal --set actuator.tau_max=10 --law mb").stdout

    assert re.search(r"^mb +holds ", found, re.M)
    assert "\nnn " not in found


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


@pytest.mark.slow
def test_check_runs_each_law_once(wmr):
    late = ("--set", "clock.control=0.05", "--set", "actuator.delay=0.05")
    command = ("check", "safe-simulation", "--law", "prox, kanayama", *late)
    document, text = json.loads(wmr(*command, "--json").stdout), wmr(*command, "-v").stdout
    prox, peer = (document["nominal"][law] for law in ("prox", "kanayama"))

    assert list(prox["position_rms"]) == ["all", "last_quarter"]
    assert prox["remarks"][0]["key"] == "chatter"
    assert (peer["outcome"], peer["tracked"]) == ("completed", True)
    assert len(peer["guard_share"]) == 2
    assert document["max_period"]["prox"] == 0 < 0.05 < document["max_period"]["kanayama"]
    assert "chatter: The wheel torques change" in " ".join(text.split())
    assert max(map(len, text.splitlines())) <= 80


@pytest.mark.slow
def test_check_shows_what_the_guard_counts_on_and_leaves(wmr):
    narrow = ("--set", "limits.v_u1=1,0.11", "--set", "limits.v_u2=0.8,0.105")
    command = ("check", "safe-simulation", "--law", "prox", *narrow)
    guard, text = json.loads(wmr(*command, "--json").stdout)["guard"], wmr(*command, "-v").stdout
    said = " ".join(text.split())

    assert guard["usable_speed"][1] == pytest.approx(0.11 - 15 * 0.01 / 4.86)
    assert guard["reference_speed"] == [pytest.approx(0.2), pytest.approx(0.1)]
    assert guard["dbar"] == guard["sources"]["dbar"]["torque noise"] == [60, 15]
    assert guard["M_max"] == [71.5, pytest.approx(7.7)]
    assert "dbar 60 N, 15 N m (torque noise); nbar 0 m/s, 0 rad/s; no delay; no lag" in said
    assert "it leaves at most 0.965 m/s, 0.0791 rad/s against friction" in said
    assert "changed 0 % of the thrusts and 100 % of the moments" in said.replace("99.9", "100")
    short = ("--set", "clock.duration=2")
    assert json.loads(wmr(*command, *short, "--no-guard", "--json").stdout)["guard"] is None


def test_check_without_a_compiler_says_so(wmr, monkeypatch):
    def missing(*_, **__):
        raise CompilerError("no C compiler was found.")

    monkeypatch.setattr("wmr_ctrl.api.simulate", missing)
    found = wmr("check paper-simulation-nominal --law mb --json")

    assert found.exit_code == 0
    assert json.loads(found.stdout)["nominal"] == {}
    assert "no law was run" in found.stderr


def test_check_takes_overrides(wmr):
    document = json.loads(
        wmr("check paper-simulation --law mb --set clock.control=0.1 --json").stdout
    )

    assert "clock.control" in {w["key"] for w in document["laws"]["mb"]["warnings"]}


@pytest.mark.parametrize(
    "command",
    [
        ("run", "safe-simulation", "--engine", "numpy", "--set", "clock.duration=0.2"),
        ("scenarios",),
        ("scenarios", "--reference", "waypoints"),
        ("laws",),
    ],
)
@pytest.mark.slow_but("command1", "command2", "command3")
def test_no_width_loses_a_letter(wmr, monkeypatch, command):
    letters = Counter(filter(str.isalnum, wmr(*command).stdout))
    for columns in ("20", "40", "60", "200"):
        monkeypatch.setenv("COLUMNS", columns)

        assert Counter(filter(str.isalnum, wmr(*command).stdout)) == letters


@pytest.mark.parametrize("preset", preset_names())
def test_every_key_of_a_preset_does_something(preset):
    assert idle_keys(load_scenario(preset)) == ()


@pytest.mark.parametrize(
    "preset, idle, switch",
    [
        ("paper-simulation", {"gyro.noise": 0.1}, {"gyro.enabled": True}),
        ("paper-simulation", {"slope.direction": 1.0}, {"slope.angle": 0.05}),
        ("paper-simulation", {"encoder.window": 0.02}, {"encoder.counts": 1024.0}),
        ("paper-simulation", {"actuator.lag_spread": 0.2}, {"actuator.lag": 0.02}),
        ("paper-simulation", {"base.tau": [0.3, 0.3]}, {"base.kind": "velocity"}),
        ("paper-simulation", {"filter.gain": [0.9, 1.1]}, {"base.kind": "velocity"}),
        ("turtlebot3-burger", {"base.kp": 9.0}, {"base.loop": "pi", "filter.kind": "none"}),
        ("turtlebot3-burger", {"guard.alpha": 3.0}, {}),
    ],
)
def test_keys_of_what_is_switched_off_are_told(preset, idle, switch):
    (key,) = idle

    assert idle_keys(load_scenario(preset, idle)) == (key,)
    assert not switch or key not in idle_keys(load_scenario(preset, {**idle, **switch}))


def test_check_tells_keys_without_effect(wmr):
    """Those of presets are nobody's fault: the Burger has a guard's masses, which it inherits."""
    short = ("--law", "pid", "--set", "clock.duration=0.2", "--set", "changes=[]")
    idle = ("--set", "gyro.noise=0.1", "--set", "metrics.rms_from=0.1", "--set", "gains.mb.rho=9,9")
    found = wmr("check", "paper-simulation", *short, *idle)
    only = wmr("check", "paper-simulation", *short, *idle, "--only", "corridor")

    preset = wmr("check turtlebot3-burger --law pid --set clock.duration=0.2")

    assert all("here: gyro.noise, gains.mb.rho." in item.stderr for item in (found, only))
    assert "guard.M_" not in preset.stdout + preset.stderr
