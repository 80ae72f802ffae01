"""Meaning of a study's plan, and refused plans."""

import csv
import math
from tomllib import loads

import pytest

from tests.simulation.campaign.studies import PLAN, table_of
from tests.tables import cases
from wmr_ctrl.core import errors
from wmr_ctrl.core.errors import ArgumentError, ScenarioError, UnknownNameError
from wmr_ctrl.simulation.campaign.study_plan import load_plan, plan_of


def test_every_combination_has_one_row_in_the_order_of_the_index(tmp_path):
    rows = list(csv.DictReader(table_of(tmp_path / "s").decode().splitlines()))

    assert [int(row["index"]) for row in rows] == list(range(2 * 3 * 2 * 2 * 5))
    named = ("robot.m", "robot.mu", "law", "guard", "seed")
    assert len({tuple(row[key] for key in named) for row in rows}) == len(rows)
    assert list(rows[0])[:7] == ["index", "law", "guard", "seed", "robot.m", "robot.mu", "outcome"]
    assert {row["ise_total"] for row in rows if row["seed"] == "4"} == {""}


@pytest.mark.parametrize(
    "changed",
    cases("""
        seeds = {count = 6}
        seeds = {count = 5, first = 1}
        stop = {figure = "violated", half_width = 0.1}
        stop = {figure = "violated", half_width = 0.2}
        figures = ["ise_total"]
        plant = "mujoco"
        set = {"robot.I" = 6.0}
        sample = {method = "latin-hypercube", n = 3, robot = {mu = [0.05, 0.1]}, seed = 4}
    """),
)
def test_a_study_is_identified_by_all_that_determines_its_results(changed):
    assert plan_of({**PLAN, "seeds": {"count": 5}, "chunk": 9}).identity == IDENTITY
    assert plan_of({**PLAN, "seeds": {"count": 5}, **loads(changed)}).identity != IDENTITY


IDENTITY = plan_of({**PLAN, "seeds": {"count": 5}}).identity


def test_the_points_of_a_latin_hypercube_lie_anywhere_in_their_strata():
    """Within a stratum they are uniform: mean 1/2, standard deviation 1/sqrt(12), each to five
    standard errors.
    """
    sample = plan_of({**PLAN, "sample": {"n": 400, "robot.mu": [0.0, 1.0]}}).sample
    within = sample.points[:, 0] * 400 % 1.0

    assert within.mean() == pytest.approx(0.5, abs=5 / math.sqrt(12 * 400))
    assert within.std() == pytest.approx(1 / math.sqrt(12), abs=5 / math.sqrt(180 * 400) * 1.8)


@pytest.mark.parametrize(
    "changed, error, words",
    cases(r"""
        grid = {"robot.mm" = [1]} | ScenarioError | robot.mm
        grid = {"robot.m" = []} | ArgumentError | at least one value
        grid = {"robot.m" = [50, -1]} | ScenarioError | robot.m
        grid = {"robot.mu" = [0.1]} | ArgumentError | not both
        set = {"robot.m" = 50} | ArgumentError | robot\.m: .* \[set\] and \[grid\]
        set = {robot = {mu = 0.1}} | ArgumentError | robot\.mu: .*\[set\] and \[sample\]
        figures = ["speed"] | UnknownNameError | speed
        figures = ["slipped"] | UnknownNameError | slipped
        plant = "bullet" | ScenarioError | mujoco
        seeds = 1000000000000 | ArgumentError | at most 1e\+09
        seeds = 0 | ScenarioError | seeds = 0 must be at least 1
        sample = {"robot.mu" = [0.1, 0.1]} | ArgumentError | range
        sample = {seed = -1, "robot.mu" = [0, 1]} | ScenarioError | sample.seed = -1
        sample = {method = "sobl", "robot.mu" = [0, 1]} | ScenarioError | near: sobol
        sample = {sed = 1, "robot.mu" = [0, 1]} | ScenarioError | near: seed
        stop = {figure = "violated"} | ScenarioError | half_width is missing
        stop = {figur = "violated"} | UnknownNameError | near: figure
        stop = 3 | ScenarioError | written as \[stop\]
        stop = {figure = "tau_rms", half_width = 0.1} | UnknownNameError | tau_rms
        grids = {} | UnknownNameError | grid
        laws = [] | ScenarioError | laws
        guard = ["yes"] | ScenarioError | guard.*\[false, true\]
        set = {"guard.enabled" = false} | ArgumentError | \[set\].*`guard`
        grid = {"guard.enabled" = [false, true]} | ArgumentError | \[grid\].*`guard` at the top
    """),
)
def test_a_bad_plan_is_refused_by_its_key(changed, error, words):
    with pytest.raises(getattr(errors, error), match=words):
        plan_of({**PLAN, **loads(changed)})


def test_a_plan_without_a_key_is_refused(tmp_path):
    (tmp_path / "empty.toml").write_text("# nothing yet\n")

    with pytest.raises(ArgumentError, match=r"empty\.toml is empty"):
        load_plan(tmp_path / "empty.toml")


@pytest.mark.parametrize(
    "text, named",
    [
        ("chunkk = 3\n", "plan"), ("chunk = 0\n", "plan"),
        ('set = {"robot.mm" = 3}\n', "plan"), ('scenario = "own.toml"\n', "own"),
    ],
)  # fmt: skip
def test_an_error_names_the_file_of_its_key(tmp_path, text, named):
    (tmp_path / "own.toml").write_text("[robot]\nmm = 3\n")
    (tmp_path / "plan.toml").write_text(text)

    with pytest.raises((ScenarioError, UnknownNameError)) as refused:
        load_plan(tmp_path / "plan.toml")

    assert str(refused.value).endswith(f"(In {tmp_path / named}.toml.)")
