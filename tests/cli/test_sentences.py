"""Arguments that commands pass on, and sentences that they make of the answers."""

import json
from dataclasses import replace
from importlib import import_module
from math import inf

import click
import pytest

from tests.commands import flat
from tests.papers_robot import paper
from wmr_ctrl import api, simulate
from wmr_ctrl.cli import check_sentences
from wmr_ctrl.cli.console import short_number
from wmr_ctrl.control.guard.price import early_speed
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.fields.section import quantities
from wmr_ctrl.results import outcome_of
from wmr_ctrl.results import summary as figures_of
from wmr_ctrl.results.verdicts import Warning
from wmr_ctrl.theory import checks
from wmr_ctrl.theory.checks import Stability
from wmr_ctrl.world.scenario import load_scenario, override
from wmr_ctrl.world.scenario.sections import Change

check, compare, runs, summary = (
    import_module(f"wmr_ctrl.cli.{name}")
    for name in ("check_answers", "compare", "runs", "summary")
)
BOTH = Warning("limits.v_u1", "of both", "Eq. (1)")
ONE, OTHER = Warning("robot.m", "of one", "Eq. (2)"), Warning("robot.I", "of the other", "Eq. (3)")
NOTED = Warning("robot.mu", "noted", "Eq. (4)", objects=False)
SHORT = {"clock.duration": 0.2, "metrics.rms_from": 0.0}


@pytest.fixture(scope="module")
def run():
    return simulate(load_scenario("paper-simulation-nominal", SHORT), "pid", engine="numpy")


@pytest.fixture
def asked(monkeypatch, run):
    """Laws and seeds of the requested runs; a replacement of `simulate` records them and makes no
    run.
    """
    found = []

    def note(_, law, *, seed=0, **__):
        found.append((law, seed))
        return run

    monkeypatch.setattr(api, "simulate", note)
    return found


def test_every_law_is_compared_with_the_seed_that_was_given(asked):
    list(compare._simulated(["far-start"], ["pid", "mb"], 7, (), None))
    runs._simulated(paper(), "prox", True, 5, "numpy", "ode", "why")

    assert asked == [("pid", 7), ("mb", 7), ("prox", 5)]


def test_before_a_run_objections_are_warnings_and_notes_are_notes(asked, monkeypatch, capsys):
    monkeypatch.setattr(checks, "warnings_heard", lambda *_: (ONE, NOTED))
    runs._simulated(paper(), "prox", True, 0, "numpy", "ode", "why")
    said = capsys.readouterr().err

    assert "warning: 1 objection of theory (robot.m): why --only robot.m\n" in said
    assert "note: 1 note of theory (robot.mu): why --only robot.mu\n" in said


def test_a_run_that_an_fmu_ended_exits_with_3(monkeypatch, capsys, run):
    for name in ("write_run", "show"):
        monkeypatch.setattr(runs, name, lambda *_, **__: None)
    seen = replace(run.monitor, failure="it refused a step")
    runs.deliver(run, False, False)
    with pytest.raises(click.exceptions.Exit) as caught:
        runs.deliver(replace(run, monitor=seen, outcome=outcome_of(seen, run.guard)), False, False)

    assert caught.value.exit_code == 3
    assert capsys.readouterr().err == "error: it refused a step\n"


@pytest.mark.parametrize(
    "value, text",
    [(0.0, "0"), (9e-4, "<0.001"), (-9e-4, "<0.001"), (1e-3, "0.001"), (-1.5, "-1.5"), (2, "2")],
)
def test_three_digits_as_long_as_they_say_something(value, text):
    assert short_number(value) == text


def test_a_row_has_millimetres_then_si_units(run):
    figures = figures_of(run)
    values = (
        *(1e3 * figures["tracking"]["drive"][key] for key in ("position_rms", "position_max")),
        *figures["max_abs_v"], figures["tau_peak"], figures["torque_change_rms"],
    )  # fmt: skip

    assert compare._row("pid", run) == ("pid", *map(short_number, values), run.outcome.value)


def test_a_comparison_judges_the_drive_and_names_every_limit(run):
    """A path that stops is at rest in its last quarter, so the drive is judged instead."""
    stops = replace(run, settings=replace(run.settings, arrival=0.1, v_u1=(0.9, 1.4)))
    text = flat(compare.comparison_text({"pid": run, "mb": stops}))

    assert "over the last quarter or drive (0.05 to 0.1 s) [mm]" in text
    assert "limits 1 m/s and 1.5 rad/s or 0.9 m/s and 1.4 rad/s." in text
    assert "over the last half or drive (0.05 to 0.1 s) [N m]" in text
    changed = dict(summary.rows_of(stops, verbose=True))["wheel torque, change"]
    assert changed.endswith("RMS per sample, drive (0.05 to 0.1 s)")


def answers(law="pid", **changes):
    found = check.find_answers(paper(), (law,), (), "corridor")
    return replace(found, **changes)


def test_what_all_of_several_laws_have_in_common_is_said_once():
    several = {"pid": (BOTH, ONE), "mb": (OTHER, BOTH), "prox": (ONE, BOTH)}
    each = [(None, BOTH), ("pid", ONE), ("mb", OTHER), ("prox", ONE)]

    assert list(check._merged(answers(warned=several))) == each
    alone = check._merged(answers(warned={"pid": (ONE, BOTH)}))
    assert list(alone) == [("pid", ONE), ("pid", BOTH)]


def test_stable_periods_delays_and_masses_are_told_as_they_were_found():
    limits = Stability(0.003, 0.04, 0.05, (0.5, 2.0), 1e-4)
    document = json.loads(json.dumps(check.document(answers(stable={"pid": limits}))))
    keys = "min_period", "max_period", "max_delay", "mass_range"

    assert [document[key]["pid"] for key in keys] == [0.003, 0.04, 0.05, [0.5, 2.0]]


@pytest.mark.parametrize(
    "shortest, period, cell",
    [(0.0, 0.04, "40"), (0.003, 0.04, "3 to 40"), (0.0, inf, "any"), (0.0, 0.0, "none")],
)
def test_stable_periods_are_in_milliseconds(shortest, period, cell):
    found = answers(stable={"pid": Stability(shortest, period, None, None, 1e-4)})

    assert list(check._cells(found, "pid"))[1] == cell


def test_grip_is_a_note(monkeypatch):
    monkeypatch.setattr(checks, "warnings_heard", lambda *_: (ONE,))
    monkeypatch.setattr(checks, "grip_warnings", lambda _: (OTHER,))
    monkeypatch.setattr(checks, "stability", lambda *_: Stability(0.0, inf, None, None, 1e-4))
    monkeypatch.setattr(check, "_runs", lambda *_: {})
    found = check.find_answers(paper(), ("pid",), (), None)

    assert found.warned["pid"] == (ONE, replace(OTHER, objects=False))


def test_a_law_is_run_for_two_million_steps_at_most(monkeypatch):
    clock = {"clock.control": 0.03, "clock.plant": 0.001, "clock.duration": 3000.0}
    long = override(paper(), {**clock, "metrics.split": 2500.0})
    short = check._short(long)

    assert short.clock.duration == pytest.approx(66_666 * 0.03)  # of 2000 s, whole periods
    assert short.metrics.split == pytest.approx(33_333 * 0.03)
    assert check._short(paper()) == paper()
    made = []
    monkeypatch.setattr(api, "simulate", lambda scenario, _: made.append(scenario))
    check._runs(long, ("pid", "mb"))
    assert made == [short, short]


def test_changes_are_announced_in_plain_words():
    later = {"changes": [{"t": 0.05, "m": 65.0}, {"t": 0.1, "mu": 0.15, "I": 7.0, "m": 60.0}]}
    told = [
        "From 0.05 s on the robot weighs 65 kg.",
        "From 0.1 s on the robot weighs 60 kg, has an inertia of 7 kg m2 and has a friction "
        "coefficient of 0.15.",
    ]
    run = simulate(load_scenario("paper-simulation", SHORT | later), "pid", engine="numpy")
    case = override(paper(), later)
    checked = list(check.head(replace(answers(), scenario=case)))

    assert [item.sentence for item in case.changes] == told
    assert " ".join(checked[1:3]).split() == " ".join(told).split()
    for text in (summary.summary_text(run).partition("\n")[2], compare.comparison_text({"a": run})):
        assert flat(text).startswith(" ".join(told))


def test_every_key_of_a_change_has_words():
    numbers = {name: 0.25 + place for place, (name, _) in enumerate(quantities(Change))}
    sentence = Change(**numbers).sentence

    assert all(f"{value:g}" in sentence for value in numbers.values())


@pytest.mark.parametrize("share, said", [(0.5, True), (1.0, False)])
def test_that_a_run_of_a_check_ends_early_is_said(run, share, said):
    lasts = replace(run.settings, duration=share * paper().clock.duration)
    head = "\n".join(check.head(answers(runs={"pid": replace(run, settings=lasts)})))

    assert ("for 2000000 plant steps only" in flat(head)) is said


@pytest.mark.parametrize("room, said", [(1e-3, False), (-1e-3, True)])
def test_a_start_that_a_push_may_take_outside_has_to_come_back_first(room, said):
    """Before the first late command acts, a push adds to the speed at the start."""
    late = {"guard.enabled": True, "actuator.delay": 0.02, "disturbance.truncate": 3.0}
    gained = early_speed(settle(override(paper(), late), None).guard)
    most = paper().limits.v_u1
    start = {"initial.velocity": [0.0, -(most[1] - gained[1] - room)]}
    text = check_sentences.promise(settle(override(paper(), late | start), None))

    assert gained[1] > 2e-3
    assert text.startswith("Guarded")
    assert ("once the speed is back from its start" in text) is said
