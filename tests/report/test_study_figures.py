"""Pictures of studies: indices at each point of the grid, missing values, values of any size."""

import re

import numpy as np
import pytest

from wmr_ctrl.report.study_figures import _bins, _by_group, _indices, _maps
from wmr_ctrl.report.study_shares import shares_of
from wmr_ctrl.report.study_table import StudyTable
from wmr_ctrl.simulation.campaign.study_plan import plan_of

PLAN = {
    "laws": ["mb", "prox"],
    "guard": [True],
    "seeds": 2,
    "figures": ["position_rms"],
    "grid": {"clock.control": [0.005, 0.01]},
    "sample": {"method": "sobol", "n": 64, "robot.mu": [0.0, 1.0], "robot.m": [40, 60]},
}
WHEELS = "guard: the wheels cannot hold the robot: {:g} > 2 is needed, but 1 > 2. It holds from 3."


def table_of(value, refused=None, **changes):
    """The table of a plan whose figure is ``value(row)``; ``refused(row)``: rows without one."""
    plan = plan_of({key: value for key, value in {**PLAN, **changes}.items() if value})
    cells = [(index, *plan.values(index // plan.seeds)) for index in range(plan.runs)]
    rows = [
        {**dict(zip(("index", *plan.keys), cell, strict=True)),
         "law": plan.case(cell[0] // plan.seeds).law} for cell in cells
    ]  # fmt: skip
    without = np.array([bool(refused and refused(row)) for row in rows])
    numbers = {key: np.array([float(row[key]) for row in rows]) for key in ("index", *plan.keys)}
    shown = np.where(without, np.nan, [value(row) for row in rows])
    told = [
        WHEELS.format(row["robot.m"]) if no else "" for row, no in zip(rows, without, strict=True)
    ]
    return StudyTable(
        plan.described(), {**numbers, "position_rms": shown},
        np.array([f"{row['law']}, guarded" for row in rows]),
        np.where(without, "refused", "completed"), np.array(told), {},
    )  # fmt: skip


def test_indices_are_those_of_each_point_of_the_grid():
    """At 5 ms only mu matters, at 10 ms only m; each index is then 1."""
    pytest.importorskip("SALib")
    table = table_of(lambda r: r["robot.mu"] if r["clock.control"] < 0.007 else r["robot.m"] / 60)
    axes = _indices(table).axes
    titles = [ax.get_title() for ax in axes]

    assert len(axes) == 4
    assert ["0.005" in title for title in titles] == [True, True, False, False]
    for ax, whole in zip(axes, [[1, 0, 1, 0]] * 2 + [[0, 1, 0, 1]] * 2, strict=True):
        assert [bar.get_height() for bar in ax.patches] == pytest.approx(whole, abs=0.1)


def test_a_missing_index_has_its_reason():
    pytest.importorskip("SALib")
    table = table_of(lambda r: 1.0, lambda r: r["law"] == "prox" and r["robot.m"] > 55)
    constant, refused, *_ = _indices(table).axes

    assert "the same in all runs" in constant.texts[0].get_text().replace("\n", " ")
    said = refused.texts[0].get_text().replace("\n", " ")
    assert re.search(r"runs have no value of \w+: refused", said)


def simple(values, laws=("mb",), unit="m"):
    """Runs with these figures, for each law the same, over a mass and a friction."""
    rng, whole = np.random.default_rng(1), np.tile(values, len(laws))
    numbers = {
        "position_rms": whole,
        "robot.m": rng.uniform(25.3, 88.0, whole.size),
        "robot.mu": np.repeat([0.1, 0.2], whole.size // 2),
    }
    plan = {"figures": ["position_rms"], "grid": {"robot.mu": [], "robot.m": []}, "sample": None}
    none = np.full(whole.size, "")
    units = {"position_rms": unit}
    return StudyTable(plan, numbers, np.repeat(laws, len(values)), none, none, units)


@pytest.mark.parametrize(
    "size, unit, label", [(1, "m", "m"), (0.01, "m", "mm"), (0.01, "N.m", "N m")]
)
def test_small_lengths_are_drawn_in_mm_and_outliers_do_not_crush_the_rest(size, unit, label):
    values = np.append(size * np.linspace(1, 1.2, 99), 4000 * size)
    axes = _by_group(simple(values, unit=unit)).axes[0]

    assert axes.get_ylabel() == f"position_rms [{label}]"
    assert axes.get_ylim()[1] < (40 if label == "mm" else 4)


def test_bins_have_round_edges_and_all_values():
    values = simple(np.ones(100)).numbers["robot.m"]
    bins = _bins(values)
    edges = np.array(bins.labels, dtype=float)

    assert edges.tolist() == [20, 30, 40, 50, 60, 70, 80, 90]
    assert (edges[bins.places] <= values).all()
    assert (values <= edges[bins.places + 1]).all()
    assert bins.ticks.tolist() == [k - 0.5 for k in range(8)]


@pytest.mark.parametrize("laws, empty", [("abcd", 0), ("abc", 0), ("abcdef", 0), ("abcde", 1)])
def test_panels_leave_as_few_places_empty_as_can_be(laws, empty):
    figure = _maps(simple(np.linspace(0.1, 0.2, 20), tuple(laws)), "position_rms")
    shown = [axes.axison for axes in figure.axes[:-1]]

    assert shown.count(False) == empty


@pytest.mark.parametrize("grid, sample, points", [
    (PLAN["grid"], {}, [", clock.control = 0.005", ", clock.control = 0.01"]),
    (PLAN["grid"], PLAN["sample"], [""]), ({}, {}, [""]),
])  # fmt: skip
def test_shares_are_by_point_where_a_grid_is_all_that_changes(grid, sample, points):
    table = table_of(lambda row: 1.0, grid=grid, sample=sample)
    laws = ("mb, guarded", "prox, guarded")

    assert [one.cell for one in shares_of(table)] == [law + at for law in laws for at in points]
