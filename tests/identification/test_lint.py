"""Faults that logs have are told by name, before anything is fitted; good logs are not accused."""

import math

import numpy as np
import pytest

from benchmarks.own_plant import log_of
from tests.identification.conftest import KNOWN, POSED, TRUTH
from tests.papers_robot import paper
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.identification import identify
from wmr_ctrl.identification.logs import lint
from wmr_ctrl.identification.logs.log import (
    FACTORS,
    LogError,
    of_columns,
    unit_of,
    with_counts,
    with_torques,
)
from wmr_ctrl.identification.logs.mended import mended
from wmr_ctrl.identification.logs.samples import motion_of, wheels
from wmr_ctrl.world.encoder import COUNTS
from wmr_ctrl.world.scenario import override

T, RIGHT, LEFT = "t [s]", "wheel_counts[1] [1]", "wheel_counts[2] [1]"
TAU, TAU_LEFT = "tau_right [N.m]", "tau_left [N.m]"
X, Y, THETA = "x [m]", "y [m]", "theta [rad]"


def put(log, **changes):
    return {**log, **{globals()[key]: value for key, value in changes.items()}}


def later(values, rows):
    return np.concatenate((np.full(rows, values[0]), values[:-rows]))


def in_row(log, row, name, value):
    return put(log, **{name: np.where(np.arange(len(log[T])) == row, value, log[globals()[name]])})


def reset(log):
    at = len(log[T]) // 2
    return put(log, RIGHT=np.concatenate((log[RIGHT][:at], log[RIGHT][at:] - log[RIGHT][at])))


def turned_by(angle):
    c, s = np.cos(angle), np.sin(angle)
    return lambda log: put(log, X=c * log[X] - s * log[Y], Y=s * log[X] + c * log[Y])


CORRUPTIONS = {
    "not a number": (lambda log: in_row(log, 300, "RIGHT", np.inf), "first in row 301"),
    "time goes back": (lambda log: put(log, T=np.where(log[T] > 12, log[T] - 5, log[T])), "back"),
    "times twice": (lambda log: put(log, T=np.floor(20 * log[T]) / 20), "time of the row before"),
    "milliseconds": (lambda log: put(log, T=1e3 * log[T]), "milliseconds"),
    "microseconds": (lambda log: put(log, T=1e6 * log[T]), "microseconds"),
    "nanoseconds": (lambda log: put(log, T=1e9 * log[T]), "nanoseconds"),
    "few rows": (lambda log: {k: v[:40] for k, v in log.items()}, "rows"),
    "short": (lambda log: {k: v[:300] for k, v in log.items()}, "too short"),
    "standing": (lambda log: put(log, RIGHT=0 * log[RIGHT], LEFT=0 * log[LEFT]), "moves in"),
    "counter set back": (reset, "jumps"),
    "counts lost": (lambda log: put(log, LEFT=log[LEFT] + 700 * (log[T] > 14)), "jumps"),
    "torques swapped": (lambda log: put(log, TAU=log[TAU_LEFT], TAU_LEFT=log[TAU]), "swapped"),
    "right torque reversed": (lambda log: put(log, TAU=-log[TAU]), "reversed"),
    "left counter reversed": (lambda log: put(log, LEFT=-log[LEFT], X=log[X]), "reversed"),
    "both reversed": (lambda log: put(log, TAU=-log[TAU], TAU_LEFT=-log[TAU_LEFT]), "reversed"),
    "motion before torque": (
        lambda log: put(log, TAU=later(log[TAU], 12), TAU_LEFT=later(log[TAU_LEFT], 12)),
        "before its torque",
    ),
    "degrees": (lambda log: put(log, THETA=np.degrees(log[THETA])), "degrees"),
    "millimetres": (lambda log: put(log, X=1e3 * log[X], Y=1e3 * log[Y]), "millimetres"),
    "quarter counts": (
        lambda log: put(log, RIGHT=np.floor(log[RIGHT] / 4), LEFT=np.floor(log[LEFT] / 4)),
        "counts",
    ),
    "theta reversed": (lambda log: put(log, THETA=-log[THETA]), "reversed"),
    "heading of REP 103": (lambda log: put(log, THETA=log[THETA] + np.pi / 2), "REP 103"),
    "x and y exchanged": (lambda log: put(log, X=log[Y], Y=log[X]), "exchanged"),
    "x reversed": (lambda log: put(log, X=-log[X]), "x or y is reversed"),
    "y reversed": (lambda log: put(log, Y=-log[Y]), "x or y is reversed"),
    "another frame": (turned_by(0.7), "at 130 degrees to theta"),
    "three times the way": (lambda log: put(log, X=3 * log[X], Y=3 * log[Y]), "3.* times that"),
}  # fmt: skip


@pytest.mark.parametrize("fault", CORRUPTIONS)
def test_a_fault_is_told_by_name(posed, fault):
    change, word = CORRUPTIONS[fault]
    log = {key: np.asarray(value).tolist() for key, value in change(posed).items()}

    with pytest.raises(LogError, match=word) as told:
        identify(log, overrides=KNOWN)

    assert "\n" not in str(told.value)


def test_good_logs_are_not_accused(driven):
    scenario = override(paper(), KNOWN)
    for robot in range(4):
        log = of_columns("log", log_of(driven, robot, POSED))
        assert not mended(log).notes
        samples = motion_of(log, scenario, COUNTS.name)
        lint.check_motion("log", samples, TRUTH.l, 10.0)
        lint.check_torques("log", samples, TRUTH.l)
        lint.check_poses("log", log, samples)


def test_poses_of_a_straight_drive_tell_no_ratio_of_turns():
    rng, t = np.random.default_rng(0), np.arange(800) * 0.015
    v = 0.3 * (np.floor(t / 1.5) % 3 - 1)
    noise = rng.normal(0, 0.3, len(t))
    log = of_columns("log", {"t": t, "v1": v, "omega": noise, "x": 0 * t,
                             "y": np.cumsum(v) * 0.015, "theta": 0 * t})  # fmt: skip
    samples = motion_of(log, paper(), "v1", ("v1", "omega"))

    way, turn = lint.pose_ratios(log, samples)

    assert way == pytest.approx(1.0, abs=0.02)
    assert math.isnan(turn)
    lint.check_poses("log", log, samples)


def test_poses_tell_the_size_of_the_wheels(driven):
    log = of_columns("log", log_of(driven, 0, POSED))
    samples = motion_of(
        log, override(paper(), KNOWN | {"robot.r": 1.0, "robot.l": 1.0}), COUNTS.name
    )

    r, turn = lint.pose_ratios(log, samples)

    assert r == pytest.approx(TRUTH.r, rel=0.02)
    assert r / turn == pytest.approx(TRUTH.l, rel=0.02)


@pytest.mark.parametrize(
    "header, word",
    [
        ("t [s],wheel_counts[1] [1]", "belong together"),
        ("time [s],v1 [m/s]", "named t"),
        ("t [s],v1 [kg],omega [rad/s]", "does not fit it"),
    ],
)
def test_headers_are_checked(tmp_path, header, word):
    path = tmp_path / "log.csv"
    row = ",".join("1" for _ in header.split(","))
    path.write_text(f"{header}\n" + f"{row}\n" * 60)

    with pytest.raises(LogError, match=word):
        identify(path)


SAME = (
    ("t", "s", 1.0, ("ms", 1e3), ("us", 1e6), ("ns", 1e9)),
    ("x", "m", 1.0, ("mm", 1e3), ("cm", 1e2)),
    ("theta", "rad", np.pi, ("deg", 180.0)),
    ("omega", "rad/s", np.pi, ("deg/s", 180.0)),
    ("wheel_speed[1]", "rad/s", 2 * np.pi, ("rpm", 60.0)),
    ("v1", "m/s", 1.0, ("mm/s", 1e3)),
    ("tau_right", "N.m", 1.0, ("N.mm", 1e3), ("Nm", 1.0), ("N m", 1.0)),
    ("current_right", "A", 1.0, ("mA", 1e3)),
    ("voltage_right", "V", 1.0, ("mV", 1e3)),
    ("wheel_counts[1]", "1", 7.0, ("counts", 7.0), ("ticks", 7.0)),
)
"""A column, a size in our unit, and the same size in others."""
TOGETHER = {
    "x": ("y", "theta"), "theta": ("x", "y"), "omega": ("v1",), "v1": ("omega",),
    "tau_right": ("tau_left",), "current_right": ("current_left",),
    "voltage_right": ("voltage_left",),
    "wheel_speed[1]": ("wheel_speed[2]",), "wheel_counts[1]": ("wheel_counts[2]",),
}  # fmt: skip


@pytest.mark.parametrize("row", SAME, ids=lambda row: row[0])
def test_a_size_is_the_same_in_every_unit(row):
    name, own, size, *others = row

    for unit, number in ((own, size), *others):
        log = {} if name == "t" else {"t [s]": [0.0, 1.0]}
        log |= {key: [0.0, 0.0] for key in TOGETHER.get(name, ("v1", "omega"))}
        read = of_columns("log", {**log, f"{name} [{unit}]": [0.0, number]})
        values = read.times["v1"] if name == "t" else read.columns[name]

        assert values.tolist() == pytest.approx([0.0, size], rel=1e-15), unit


def test_factors_between_units_are_told_within_eight_per_cent_of_them():
    for factor, sense in FACTORS.items():
        for near in (0.96, 1.0, 1.04):
            assert unit_of(near * factor) == sense
            other_way = " for ".join(reversed(sense.split(" for ")))
            assert unit_of(1 / (near * factor)) == other_way
        assert unit_of(0.8 * factor) is None
        assert unit_of(1.2 * factor) is None


def test_a_column_that_is_there_twice_is_refused():
    columns = ("t [s]", "v1 [m/s]", "omega [rad/s]", "v1 [mm/s]")
    with pytest.raises(LogError, match="two columns are named v1"):
        of_columns("log", {key: [0.0, 1.0] for key in columns})


@pytest.mark.parametrize("constant", [0.0, -1.0, math.inf, math.nan])
def test_a_torque_per_ampere_is_positive_and_finite(constant):
    log = of_columns("log", {"t [s]": [0.0], "current_right [A]": [1.0], "current_left [A]": [2.0]})

    with pytest.raises(ArgumentError, match="positive and finite"):
        with_torques(log, constant)
    assert with_torques(log, 0.5).pair(("tau_right", "tau_left"))[1].tolist() == [[0.5, 1.0]]


def test_the_smallest_step_of_an_angle_is_a_count_and_rounding_is_none():
    turn = 2 * np.pi * np.array([0, 3, 5, 5, 6]) / 500 + [0, 0, 0, 1e-12, 0]
    log = of_columns("log", {"t [s]": range(5), "wheel_angle[1]": turn, "wheel_angle[2]": turn})

    read, counts = with_counts(log, None)

    assert counts == 500
    assert read.columns[COUNTS.elements[0]] == pytest.approx([0, 3, 5, 5, 6])


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "rows, word",
    [
        ("", "no rows"),
        ("1,2\n2,3\n", "line 2: it has another number of cells than the 3"),
        ("1,2,3,4\n\n2,3\n", "line 2: it has another number of cells"),
        ("1,2,\n2,3,fast\n", 'line 3, column omega: "fast" is not a number'),
    ],
)
def test_tables_are_checked_and_nothing_else_is_printed(tmp_path, rows, word):
    path = tmp_path / "log.csv"
    path.write_text(f"t [s],v1 [m/s],omega [rad/s]\n{rows}")

    with pytest.raises(LogError, match=word):
        identify(path)


def test_wheels_of_a_body_move_it_and_turn_it():
    speed = np.array([[0.4, 1.0], [-0.2, -3.0]])
    right, left = wheels(speed, 0.15).T

    assert (right + left) / 2 == pytest.approx(speed[:, 0])
    assert (right - left) / 0.3 == pytest.approx(speed[:, 1])
