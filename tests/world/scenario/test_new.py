"""``wmr-ctrl new``: a file that loads, is checked and drives, for any robot files."""

import json
import math
import tomllib

from hypothesis import given, settings
from hypothesis import strategies as st

from tests.cli.conftest import wmr  # noqa: F401
from tests.world.robot_files.test_parameter_files import CONTROLLER, NAV2
from tests.world.robot_files.test_urdf import PAIR, robot
from wmr_ctrl import simulate
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.control.setup import settle
from wmr_ctrl.results import tracked
from wmr_ctrl.theory.checks import filter_facts
from wmr_ctrl.world.robot_files.found import Found, Rank, merged
from wmr_ctrl.world.scenario import loads_scenario
from wmr_ctrl.world.scenario.new import new_scenario

MOST_KEYS = 25
BASES = ("velocity", "torque")


def between(low, high):
    return st.floats(math.log(low), math.log(high)).map(lambda x: float(f"{math.exp(x):.6g}"))


SIZES = {
    "robot.m": (0.5, 500), "robot.r": (0.02, 0.3), "robot.l": (0.04, 0.8),
    "limits.v_u1[1]": (0.05, 4), "limits.v_u1[2]": (0.2, 6), "base.accel[1]": (0.1, 20),
    "base.accel[2]": (0.1, 30), "base.decel[1]": (0.1, 20), "base.timeout": (0.11, 2),
    "body.radius": (0.1, 1),
}  # fmt: skip
PERIODS = st.integers(5, 100).map(lambda n: round(n * 1e-3, 3))
FOUND = st.fixed_dictionaries(
    {},
    optional={"clock.control": PERIODS} | {key: between(*ends) for key, ends in SIZES.items()},
)


@settings(max_examples=8)
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
