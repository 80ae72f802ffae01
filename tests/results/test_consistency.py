"""A foreign plant that contradicts itself is reported; one that merely lags is not."""

from dataclasses import replace

import numpy as np
import pytest

from wmr_ctrl import simulate
from wmr_ctrl.cli.summary import summary_text
from wmr_ctrl.results import Outcome, summary
from wmr_ctrl.results.consistency import CONTRADICTS, JUMP, contradictions, kept
from wmr_ctrl.world.scenario import load_scenario

CASES = (("safe-simulation", "prox"), ("turtlebot3-burger", "kanayama"))
RNG = np.random.default_rng(5)


@pytest.fixture(scope="module", params=CASES, ids=str)
def run(request):
    name, law = request.param
    return simulate(load_scenario(name, {"clock.duration": 20.0}), law)


def foreign(run, **columns):
    """The run as another author's plant would have made it, with other columns."""
    settings = replace(run.settings, plant_kind="fmu")
    return replace(run, settings=settings, columns={**run.columns, **columns})


ALIKE = {
    "as it is": lambda run: {},
    "pose late": lambda run: {x: np.r_[run[x][:1], run[x][:-1]] for x in ("x", "y", "psi")},
    "angle within a turn": lambda run: {"psi": (run["psi"] + np.pi) % (2 * np.pi) - np.pi},
    "another point of the robot": lambda run: {
        "x": run["x"] + 0.1 * np.cos(run["psi"]), "y": run["y"] + 0.1 * np.sin(run["psi"])
    },
    "noise": lambda run: {
        name: run[name] + size * RNG.standard_normal(run.rows)
        for name, size in (("x", 1e-3), ("y", 1e-3), ("psi", 1e-3), ("v1", 0.01), ("omega", 0.01))
    },
}  # fmt: skip
APART = {
    "axes swapped": lambda run: {"x": run["y"], "y": run["x"]},
    "heading off by a quarter": lambda run: {"psi": run["psi"] + np.pi / 2},
    "pose that stands": lambda run: {name: 0 * run[name] + 1 for name in ("x", "y", "psi")},
    "a jump later on": lambda run: {"x": run["x"] + 0.5 * (run.time > 7)},
}
A_SECOND = 1 / (2 * np.pi)
SCALED = {
    "wheels in revolutions a second": {"v1": A_SECOND, "omega": A_SECOND},
    "speed of another sign": {"v1": -1},
    "turn of another sign": {"omega": -1},
    "degrees": {"psi": 180 / np.pi},
    "millimetres": {"x": 1e3, "y": 1e3},
    "speeds of 0": {"v1": 0, "omega": 0},
    "a speed 15 % too small": {"v1": 0.85},
}


def scaled(run, factors):
    return {name: factor * run[name] for name, factor in factors.items()}


@pytest.mark.parametrize("how", [*ALIKE, "wheels that slip a little"])
def test_agreeing_outputs_are_not_blamed(run, how):
    slip = scaled(run, {"v1": 1.03, "omega": 1.03})
    told = foreign(run, **ALIKE[how](run) if how in ALIKE else slip)
    assert contradictions(told) == {}
    assert kept(told) is summary(told)["kept"] is True


@pytest.mark.parametrize("how", [*APART, *SCALED])
def test_pose_that_contradicts_the_speeds_is_told(run, how):
    told = foreign(run, **APART[how](run) if how in APART else scaled(run, SCALED[how]))
    assert CONTRADICTS in contradictions(told)
    assert kept(told) is summary(told)["kept"] is None
    assert told.outcome is Outcome.COMPLETED
    text = " ".join(summary_text(told).split())
    assert "plant contradicts itself" in text
    assert "stayed within" not in text
    assert kept(replace(told, settings=run.settings)) is True  # our own plant is not asked


def test_a_jump_in_the_first_step_is_told_by_itself(run):
    """Outputs are 0 until the first step; everything later agrees."""
    told = foreign(run, **{n: np.r_[0.0, run[n][1:]] for n in ("x", "y", "psi", "v1", "omega")})
    assert list(contradictions(told)) == [JUMP]
    assert [item.key for item in told.remarks if item.key in (JUMP, CONTRADICTS)] == [JUMP]
    assert kept(told) is None


def test_broken_limits_and_runs_without_samples(run):
    broken = replace(run.monitor, violations=3, first_violation=(1.0, 1))
    over = replace(run, monitor=broken, outcome=Outcome.LIMIT_VIOLATED)
    empty = {name: column[:0] for name, column in run.columns.items()}
    failed = replace(run.monitor, failure="the FMU failed")
    ended = replace(run, monitor=failed, outcome=Outcome.FAILED, columns=empty)

    assert kept(over) is False
    assert kept(ended) is None
    assert contradictions(replace(ended, settings=foreign(run).settings)) == {}
