"""``wmr-ctrl new``: a file that loads, is checked and drives, whatever was found."""

import json
import math
import re
import tomllib
from importlib.util import find_spec
from warnings import catch_warnings, simplefilter

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.cli.conftest import wmr  # noqa: F401
from tests.world.robot_files.test_parameter_files import CONTROLLER, NAV2
from tests.world.robot_files.test_urdf import PAIR, robot
from wmr_ctrl import command_filter, simulate
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.control.setup import settle
from wmr_ctrl.results import tracked
from wmr_ctrl.theory.checks import filter_facts
from wmr_ctrl.world.robot_files.found import Found, Rank, merged
from wmr_ctrl.world.scenario import loads_scenario
from wmr_ctrl.world.scenario.new import LAW, new_scenario

MOST_KEYS = 25
BASES = ("velocity", "torque")


def between(low, high):
    return st.floats(math.log(low), math.log(high)).map(lambda x: float(f"{math.exp(x):.6g}"))


FOUND = st.fixed_dictionaries(
    {},
    optional={
        "robot.m": between(0.5, 500),
        "robot.r": between(0.02, 0.3),
        "robot.l": between(0.04, 0.8),
        "limits.v_u1[1]": between(0.05, 4),
        "limits.v_u1[2]": between(0.2, 6),
        "base.accel[1]": between(0.1, 20),
        "base.accel[2]": between(0.1, 30),
        "base.decel[1]": between(0.1, 20),
        "base.timeout": between(0.11, 2),
        "clock.control": st.integers(5, 100).map(lambda n: round(n * 1e-3, 3)),
        "body.radius": between(0.1, 1),
    },
)


@settings(max_examples=15)
@given(values=FOUND, shape=between(0.2, 4), base=st.sampled_from(BASES))
def test_any_subset_of_findings_makes_a_scenario_that_keeps_its_limits_and_tracks(
    values, shape, base
):
    if "robot.m" in values and "robot.l" in values:
        values["robot.I"] = shape * values["robot.m"] * values["robot.l"] ** 2
    items = [Found(key, value, "f: x", Rank.CONTROLLER) for key, value in values.items()]

    made = new_scenario(merged(items), base, "mine")

    raw = tomllib.loads(made.text)
    keys = [key for key, part in raw.items() if not isinstance(part, dict)]
    inner = [key for key, part in raw.items() for _ in (part if isinstance(part, dict) else ())]
    assert len(keys) + len(inner) <= MOST_KEYS
    assert raw["assumed"] == list(made.unknown)
    scenario = scenario_of(loads_scenario(made.text))
    for key, value in values.items():
        if key in made.found and "[" not in key:
            assert scenario.value(key) == (value,)
    facts = filter_facts(settle(scenario, None)) if base == "velocity" else None
    assert settle(scenario, None).void == "" if facts is None else facts.broken == ()
    run = simulate(scenario, scenario.law)
    assert tracked(run)
    assert list(run.remarks) == []


@pytest.mark.parametrize("base", BASES)
def test_file_is_checked_and_lists_what_is_assumed(base, wmr, tmp_path):  # noqa: F811
    out = tmp_path / "mine.toml"

    made = wmr("new", out, "--base", base)

    assert made.exit_code == 0, made.stderr
    assert made.stdout.splitlines()[-1] == f"wmr-ctrl check {out}"
    assert out.read_text(encoding="utf-8").splitlines()[-1] == f"# Next: wmr-ctrl check {out}"
    checked = wmr("check", out)
    assert checked.exit_code == 0, checked.stderr
    for key in tomllib.loads(out.read_text(encoding="utf-8"))["assumed"]:
        assert key in checked.stdout
    assert "kanayama   holds" in checked.stdout
    assert "guaranteed" in checked.stdout


def test_what_rests_on_assumed_values_says_so_until_they_are_stated(wmr, tmp_path):  # noqa: F811
    file, unstated = tmp_path / "mine.toml", "Nobody stated"
    assert wmr("new", file).exit_code == 0
    keys = tomllib.loads(file.read_text(encoding="utf-8"))["assumed"]
    for assumed in (True, False):
        made = wmr("codegen", "filter", "--scenario", file, "--out", tmp_path / f"c{assumed}")
        header = (tmp_path / f"c{assumed}" / "wmr_filter.h").read_text(encoding="utf-8")
        run = simulate(str(file), "kanayama")
        with catch_warnings(record=True) as heard:
            simplefilter("always")
            command_filter(str(file))

        assert run.remarks == ()
        assert ("Nothing needs to be done" in run.explanation) is not assumed
        assert all((key in run.explanation) is assumed for key in keys)
        assert all((key in header) is assumed for key in keys if not key.startswith("limits"))
        for text in (header, made.stderr, " ".join(str(item.message) for item in heard)):
            assert (unstated in text) is assumed
        text = file.read_text(encoding="utf-8")
        file.write_text(re.sub("^assumed = .*", "", text, flags=re.MULTILINE), encoding="utf-8")


def test_all_laws_are_those_that_the_stated_robot_is_enough_for(wmr, tmp_path):  # noqa: F811
    file = tmp_path / "mine.toml"
    assert wmr("new", file).exit_code == 0

    made = wmr("compare", file, "--law", "all")
    alone = wmr("compare", file, "--law", "kanayama,mb")

    assert made.exit_code == 0, made.stderr
    head, *rows = made.stdout.splitlines()
    assert {row.split()[0] for row in rows[1:] if row.endswith("completed")} >= {LAW, "pursuit"}
    assert "mb" in made.stderr
    assert "peak" not in head, "nobody commands its torques"
    assert alone.exit_code == 2, "a law that is named is not left out"
    assert "robot.m" in alone.stderr


def test_commands_that_need_the_robot_ask_for_it_and_others_do_not(wmr, tmp_path):  # noqa: F811
    file = tmp_path / "mine.toml"
    assert wmr("new", file).exit_code == 0
    needing = [("linearize", file, "--law", "mb"), ("run", file, "--law", "mb")]
    needing += [("run", file, "--plant", "mujoco")] if find_spec("mujoco") else []

    for words in needing:
        made = wmr(*words)
        assert made.exit_code == 2, words
        assert "robot.m [kg]" in made.stderr, words

    made = wmr("linearize", file, "--against-run", "--json")
    assert made.exit_code == 0, made.stderr
    assert json.loads(made.stdout)[LAW]["ahead"]["ten_per_cent"] > 0


def test_gains_that_fit_rounding_are_not_advised(wmr, tmp_path):  # noqa: F811
    file, tuned = tmp_path / "mine.toml", ("--out", tmp_path / "tuned.toml", "--trials", 2)
    assert wmr("new", file).exit_code == 0
    pushed = ("--set", "sensor.pose_noise=0.01", "--set", "sensor.pose_period=0.1")

    for more, nothing in (((), True), (pushed, False)):
        made = wmr("tune", file, "--law", LAW, *tuned, *more)
        assert made.exit_code == 0, made.stderr
        assert ("There was nothing to tune" in made.stdout) is nothing
    begun, found = (tomllib.loads(path.read_text(encoding="utf-8")) for path in (file, tuned[1]))
    gains, sensor = found.pop("gains"), found.pop("sensor")
    assert {*gains[LAW]} >= {"k", "rate"}
    assert {*sensor} == {"pose_noise", "pose_period"}, "what nobody stated is not written"
    assert {key: found[key] for key in begun} == begun


def test_files_are_read_and_told(wmr, tmp_path):  # noqa: F811
    names = {"r.urdf": robot(PAIR), "c.yaml": CONTROLLER, "n.yaml": NAV2}
    for name, text in names.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    out, files = tmp_path / "mine.toml", [tmp_path / name for name in names]

    made = wmr("new", out, "--json", "--from", *files)

    assert made.exit_code == 0, made.stderr
    told = " ".join(made.stderr.split())
    assert "base velocity: not stated" in told
    assert "robot.l is 0.375 (c.yaml" in told, "the description says 0.2"
    told = json.loads(made.stdout)
    assert told["found"]["limits.v_max"]["value"] == [1.0, 2.0]
    assert told["found"]["limits.v_min"]["value"] == [-0.4, -1.5]
    assert told["found"]["ros.base_frame"]["value"] == "base_footprint"
    assert told["assumed"]["law"] == "kanayama"
    assert "base.tau" in told["unknown"]
    table = wmr("new", out, "--force", "--from", *files).stdout
    assert "not used: n.yaml" in " ".join(table.split())
    assert "-p base_frame:=base_footprint" in table


def test_nothing_is_overwritten(wmr, tmp_path):  # noqa: F811
    out = tmp_path / "mine.toml"
    out.write_text("mine", encoding="utf-8")
    link = tmp_path / "robot.urdf"
    link.symlink_to(out)

    for words in ((), ("--force", "--from", link)):
        refused = wmr("new", out, *words)
        assert refused.exit_code == 2
        assert refused.stderr.count("\n\n") == 0
        assert out.read_text(encoding="utf-8") == "mine"


def test_impossible_value_is_refused_with_its_file(wmr, tmp_path):  # noqa: F811
    file = tmp_path / "c.yaml"
    file.write_text(CONTROLLER.replace("publish_rate: 30.0", "publish_rate: 1e-8"), "utf-8")

    refused = wmr("new", tmp_path / "mine.toml", "--from", file)

    assert refused.exit_code == 2
    assert "c.yaml" in refused.stderr
    assert not (tmp_path / "mine.toml").exists()
