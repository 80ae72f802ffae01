"""Outcomes: which one, and the sentence that goes with it."""

import math
from dataclasses import replace

import pytest

from wmr_ctrl.results import Monitor, Outcome, RigidMonitor, outcome_of

KEPT = Monitor((0.9, 1.2))
BROKEN = Monitor((1.7, 1.2), 12, (0.0125, 1))
DIVERGED = Monitor((2.0, 1000.0), 80, (0.01, 1), (0.375, 2), "diverged")
LOST = Monitor((2.0, math.nan), 80, (0.01, 1), (0.375, 1), "non-finite")

LEFT = Monitor((0.9, 1.2), bounds_left=(2.5, 2))

FAILED = Monitor((0.9, 1.2), failure="plant.fmu (plant) refused the step at t = 0.5 s.")

CASES = [
    (FAILED, "failed"),
    (KEPT, "completed"),
    (LEFT, "bounds-left"),
    (BROKEN, "limit-violated"),
    (DIVERGED, "diverged"),
    (LOST, "non-finite"),
    (replace(BROKEN, rigid=RigidMonitor(1.985, 0.003, 443.9)), "tipped"),
    (replace(LEFT, rigid=RigidMonitor(None, 0.003, 4.0)), "slipped"),
    (replace(BROKEN, rigid=RigidMonitor(None, 0.003, 4.0)), "limit-violated"),
]


@pytest.mark.parametrize("monitor, value", CASES)
def test_the_gravest_event_gives_the_outcome(monitor, value):
    assert outcome_of(monitor, guard=True) == Outcome(value)


@pytest.mark.parametrize(
    "max_abs_v, outcome",
    [
        ((math.inf, 0.0), Outcome.NON_FINITE),
        ((0.0, math.nan), Outcome.NON_FINITE),
        ((1000.0, 0.0), Outcome.DIVERGED),
        ((math.nextafter(1000.0, 0.0), 0.0), Outcome.COMPLETED),
        ((1.0, 1.5), Outcome.COMPLETED),
    ],
)
def test_extremes_alone_never_pass_as_completed(max_abs_v, outcome):
    monitor = Monitor(max_abs_v)

    assert outcome_of(monitor) == outcome
    assert outcome.sentence(monitor).endswith(".")


@pytest.mark.parametrize("guard", [False, True])
def test_a_start_outside_is_told_as_such_and_only_then(guard):
    outside = Monitor((1.3, 0.5), violations=9, first_violation=(0.0, 1))
    sentence = Outcome.LIMIT_VIOLATED.sentence(outside, guard)
    assert "started outside the limits" in sentence
    assert ("too: switch the guard on" in sentence) is not guard
    assert "outside" not in Outcome.LIMIT_VIOLATED.sentence(BROKEN, guard)


@pytest.mark.parametrize(
    "monitor, parts",
    [
        (KEPT, ["completed", "0.9 m/s", "1.2 rad/s"]),
        (FAILED, ["ended early", "plant.fmu", "t = 0.5 s"]),
        (LEFT, ["angular velocity omega", "t = 2.5 s", "guard.dbar"]),
        (replace(BROKEN, violations=1), ["1 plant step was"]),
        (BROKEN, ["linear velocity v1", "t = 0.0125 s", "12 plant steps", "guard"]),
        (DIVERGED, ["angular velocity omega", "t = 0.375 s", "1000 rad/s", "clock.control"]),
        (LOST, ["linear velocity v1", "t = 0.375 s", "finite", "clock.plant"]),
    ],
)
def test_the_sentence_names_what_when_axis_and_remedy(monitor, parts):
    sentence = outcome_of(monitor, guard=True).sentence(monitor)

    assert [part for part in parts if part not in sentence] == []
    assert "\n" not in sentence
    assert "{" not in sentence
