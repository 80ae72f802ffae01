"""The dossier agrees with scenario, ledger and tests; without a promise there is nothing to
sign.
"""

import json
import re
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from tests.commands import finished, flat
from tests.tables import cases, changes
from wmr_ctrl import simulate
from wmr_ctrl.cli import dossier
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.results import ledger
from wmr_ctrl.world.scenario import load_scenario, scenario_hash

pytest.importorskip("z3")
ROOT = Path(__file__).parents[2]
GUARDED, GOVERNED, CLIPPED = "robot-10ms", "turtlebot3-burger", "clearpath-husky"
TESTS = sorted({row["test"] for row in dossier.TABLES["fault"]})
OWN = """
law = "kanayama"
[base]
kind = "velocity"
loop = "second-order"
frequency = 4.0
damping = 0.6
[limits]
v_u1 = [1.0, 2.0]
[reference]
kind = "circle"
radius = 1.0
rate = 0.2
[clock]
control = 0.05
[initial]
velocity = [0.0, 0.0]
[filter]
kind = "clip"
loop = "second-order"
frequency = [3.5, 4.5]
damping = [0.5, 0.7]  # source: log of 3 May, 40 s
gain = [0.9, 1.1]  # assumed
d = [0.02, 0.02]
"""
COMMAND = "another command is asked for, or one that is no number"
FIRST_ORDER = changes(
    "base.loop = 'first-order'; base.tau = 0.2;filter.loop = 'first-order'; filter.tau = [0.1, 0.3]"
)
LOOPS = {
    "loops": {},
    "band": {"filter.kind": "band"},
    "slew": {"filter.slew": (0.25, 0.25)},
}


def setup_of(source, stated=None):
    """A scenario with other numbers, settled."""
    return settle(load_scenario(source, stated or {}), "kanayama")


@pytest.fixture
def own(tmp_path):
    """File of a user's own robot."""
    path = tmp_path / "mine.toml"
    path.write_text(OWN, "utf-8")
    return str(path)


@pytest.fixture(scope="module")
def governed():
    return dossier.document(setup_of(GOVERNED), GOVERNED)


def test_every_assumption_says_who_checks_it_and_what_follows(governed):
    case = load_scenario(GOVERNED)
    values = {row["key"]: row["value"] for row in governed["assumptions"]}
    asked = ("symbol", "meaning", "checked_by", "if_broken", "monitor", "source")

    assert (governed["scenario"], governed["hash"]) == (GOVERNED, scenario_hash(case))
    assert (values["filter.tau"], values["filter.losses"]) == (case.filter.tau, 0)
    assert "|v1| <=" in governed["function"]
    assert all(row[name] for row in governed["assumptions"] for name in asked)


def test_an_entry_of_another_graph_or_that_does_not_hold_ends_it(monkeypatch):
    changed = {"filter.inside": {"graph_hash": "0" * 64}, "filter.mean": {"verdict": "OPEN"}}
    entries = tuple(replace(item, **changed.get(item.id, {})) for item in ledger.load().entries)
    monkeypatch.setattr(ledger, "load", lambda: ledger.Ledger(entries))

    with pytest.raises(ArgumentError, match=r"rests on filter\.inside, filter\.mean, which"):
        dossier.document(setup_of(GOVERNED), GOVERNED)


def test_a_comment_that_names_no_source_is_not_shown(own):
    rows = [
        *dossier.assumptions(setup_of(own), own),
        *dossier.assumptions(setup_of(own, {"filter.kind": "governor", **FIRST_ORDER}), own),
    ]
    sources = {row["key"]: row["source"] for row in rows}

    assert sources["filter.damping"] == "source: log of 3 May, 40 s"
    assert sources["filter.gain"] == "not shown: assumed"
    assert sources["clock.control"] == "not shown"


@pytest.mark.parametrize(
    "comment, shown",
    cases("""
    1 to 2; from drive.mcap, 40 s | shown
    controllers.yaml: wheel_radius | shown
    maker's page: maximum velocities | shown
    source: scales | shown
    s, bounds of the base's time constant | not shown
    YOURS? [s] bounds of the speed loop's time constant | not shown
    not measured yet | not shown
    UNKNOWN: time from command to first motion | not shown
    guess | not shown
    """),
)
def test_a_source_is_what_a_comment_calls_one(comment, shown):
    assert bool(dossier.SOURCE.search(comment)) is (shown == "shown")


def test_numbers_that_are_derived_name_what_from():
    rows = {row["key"]: row for row in dossier.assumptions(setup_of(GUARDED), GUARDED)}

    assert rows["guard.nbar"]["source"].startswith("not shown: derived from encoder")
    assert rows["guard.window"]["unit"] == "s"


@pytest.mark.parametrize("kind", ["guard", "clip", "governor", *LOOPS])
@pytest.mark.slow_but("governor")
def test_the_argument_is_that_of_the_ledger(kind, own, governed):
    source = {"guard": GUARDED, "clip": CLIPPED}.get(kind, own)
    stated = setup_of(source, LOOPS.get(kind))
    made = governed if kind == "governor" else dossier.document(stated, source)
    known = ledger.load().by_id()

    assert made["kind"] == kind
    assert made["argument"]
    assert {row["says"] for row in made["argument"]} <= set(made["promise"])
    for row in made["argument"]:
        entry = known[row["claim"]]
        assert (row["verdict"], row["graph_hash"]) == (entry.verdict, entry.graph_hash)
        assert row["by_hand"] == (entry.verdict == "HAND")
        assert entry.verdict in dossier.HOLDS
    assert all(name in known for row in made["faults"] for name in row["claims"])


def test_times_are_those_of_the_stated_bounds():
    stated = {"filter.delay": (0.01, 0.03), "filter.losses": 2, "filter.jitter": 0.005,
              "filter.hold": 0.4, "filter.trust": True}  # fmt: skip
    period = load_scenario(GOVERNED).clock.control
    times = {row["event"]: row["seconds"] for row in dossier.responses(setup_of(GOVERNED, stated))}
    (first, *_) = dossier.responses(setup_of(CLIPPED))

    assert times[COMMAND] == pytest.approx(0.03 + 3 * (period + 0.005))
    assert times["commands to the base cease"] == 0.4
    assert first["seconds"] == 1.25 * load_scenario(CLIPPED).clock.control


@pytest.mark.parametrize("axis", [0, 1])
def test_a_guarded_robot_is_back_within_its_limit_in_that_time(axis):
    stated = {"actuator.tau_max": 20.0, "clock.duration": 2.0}
    setup = setup_of("safe-simulation", stated)
    back = next(row["seconds"] for row in dossier.responses(setup) if "tenth" in row["event"])
    limit, start = setup.scenario.limits.v_u1[axis], [0.0, 0.0]
    start[axis] = 1.1 * limit

    run = simulate("safe-simulation", "prox", overrides={**stated, "initial.velocity": start})

    beyond = run["t"][abs(run[("v1", "omega")[axis]]) > limit * (1 + 1e-9)]
    assert 0 < beyond.max() < back < 2.0


def test_a_late_turning_speed_alone_or_drives_without_a_limit_promise_no_way_back():
    setup = setup_of("safe-simulation", {"actuator.tau_max": 20.0})
    late = replace(setup, guard=replace(setup.guard, age=(0.0, 0.01)))
    timely, late, strong = (
        {row["event"]: row["seconds"] for row in dossier.responses(item)}
        for item in (setup, late, setup_of("safe-simulation"))
    )
    back, seen = (
        next(item for item in timely if word in item) for word in ("tenth", "contradicts")
    )

    assert None not in (timely[back], timely[seen])
    assert late[back] is late[seen] is strong[back] is None


@pytest.mark.parametrize(
    "source, stated, words",
    [
        ("own", {"filter.d": (0.0, 0.1)}, "filter.d is 0"),
        ("paper-simulation", {}, "Not guarded"),
        (GOVERNED, {"filter.kind": "none"}, "No filter"),
        ("safe-simulation", {}, "guard.nbar is 0"),
        (GOVERNED, {"base.gain": 2.0, "filter.trust": True}, "base.gain"),
    ],
)
def test_nothing_that_is_not_promised_is_signed_for(source, stated, words, own):
    source = own if source == "own" else source
    with pytest.raises(ArgumentError, match=re.escape(words)):
        dossier.document(setup_of(source, stated), source)


def test_every_fault_names_tests_that_are_there():
    for path, name in (test.split("::") for test in TESTS):
        assert f"def {name}(" in (ROOT / path).read_text("utf-8")


@pytest.mark.slow
def test_every_test_of_a_fault_passes():
    done = finished([sys.executable, "-m", "pytest", "-q", "-n", "0", "-m", "", *TESTS], cwd=ROOT)

    assert "skipped" not in done.stdout.splitlines()[-1]


def test_the_page_has_all_sections_and_loads_nothing(wmr, tmp_path, governed, monkeypatch):
    titles = "Function | Assumptions | Argument | Response times | Faults | Not covered | Repeat it"
    path = tmp_path / "dossier.html"
    monkeypatch.setattr(dossier, "document", lambda *_: governed)
    done = wmr(f"dossier {GOVERNED} --out {path} --json")
    page, told = path.read_text("utf-8"), json.loads(done.stdout)

    assert all(f"<h2>{title}</h2>" in page for title in titles.split(" | "))
    assert not re.search(r"""(src|href)=["'](?!#)""", page)
    assert told["hash"] in page
    assert all(row["claim"] in page for row in told["argument"])
    assert "no safety function" in page


def test_what_is_refused_ends_with_2_and_writes_nothing(wmr, tmp_path):
    path = tmp_path / "dossier.html"
    done = wmr(f"dossier paper-simulation --out {path}")

    assert (done.exit_code, path.exists()) == (2, False)
    assert "there is no promise to sign for" in flat(done.stderr)
