"""Faults of logs are named before anything is fitted, and good logs are not accused."""

import math

import numpy as np
import pytest

from benchmarks.own_plant import log_of
from tests.identification.conftest import KNOWN, POSED, TRUTH
from tests.papers_robot import paper
from tests.tables import cases
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.identification import identify
from wmr_ctrl.identification.logs import lint
from wmr_ctrl.identification.logs.log import (
    FACTORS,
    TORQUES,
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

RIGHT, LEFT = COUNTS.elements


def assert_told(log, word):
    with pytest.raises(LogError, match=word) as told:
        identify({key: values.tolist() for key, values in log.items()}, overrides=KNOWN)
    assert "\n" not in str(told.value)


SCALED = """
    t | 1e3 | milliseconds
    t | 1e6 | microseconds
    t | 1e9 | nanoseconds
    wheel_counts[1] wheel_counts[2] | 0 | moves in
    tau_right | -1 | reversed
    wheel_counts[2] | -1 | reversed
    tau_right tau_left | -1 | reversed
    theta | 57.29577951308232 | degrees
    theta | -1 | reversed
    x y | 1e3 | millimetres
    x y | 3 | 3.* times that
    x | -1 | x or y is reversed
    y | -1 | x or y is reversed
"""


@pytest.mark.parametrize("names, factor, word", cases(SCALED))
def test_a_wrong_unit_or_sign_is_told_by_name(posed, names, factor, word):
    assert_told(posed | {name: float(factor) * posed[name] for name in names.split()}, word)


@pytest.mark.parametrize(
    "one, other, word", [(*TORQUES, "swapped"), ("x", "y", "x and y are exchanged")]
)
def test_two_columns_that_are_exchanged_are_told(posed, one, other, word):
    assert_told(posed | {one: posed[other], other: posed[one]}, word)


def in_half(log, shift):
    """The right counter with a shift in the second half of the log."""
    half = np.arange(len(log["t"])) >= len(log["t"]) // 2
    return {RIGHT: log[RIGHT] + half * shift(log[RIGHT][half][0])}


FAULTS = {
    "first in row 301": lambda log: {
        RIGHT: np.where(np.arange(len(log["t"])) == 300, np.inf, log[RIGHT])
    },
    "back": lambda log: {"t": np.where(log["t"] > 12, log["t"] - 5, log["t"])},
    "time of the row before": lambda log: {"t": np.floor(20 * log["t"]) / 20},
    "rows": lambda log: {key: row[:40] for key, row in log.items()},
    "too short": lambda log: {key: row[:300] for key, row in log.items()},
    "jumps by -": lambda log: in_half(log, np.negative),
    "jumps by 70": lambda log: in_half(log, lambda _: 705.0),
    "before its torque": lambda log: {name: np.roll(log[name], 12) for name in TORQUES},
    "quarter of the counts": lambda log: {name: np.floor(log[name] / 4) for name in (RIGHT, LEFT)},
    "REP 103": lambda log: {"theta": log["theta"] + np.pi / 2},
    "at 130 degrees to theta": lambda log: {"theta": log["theta"] - 0.7},
}


@pytest.mark.parametrize("word", FAULTS)
def test_a_fault_is_told_by_name(posed, word):
    assert_told(posed | FAULTS[word](posed), word)


def test_good_logs_are_not_accused(driven):
    scenario = override(paper(), KNOWN)
    for robot in range(4):
        log = of_columns("log", log_of(driven, robot, POSED))
        assert not mended(log).notes
        samples = motion_of(log, scenario, COUNTS.name)
        lint.check_motion("log", samples, TRUTH.l, 10.0)
        lint.check_torques("log", samples, TRUTH.l)
        lint.check_poses("log", log, samples)


def test_columns_of_different_lengths_are_no_log():
    with pytest.raises(ArgumentError, match="same length"):
        of_columns("log", {"t": [0.0, 0.1], "v1": [1.0]})


def test_poses_of_a_straight_drive_tell_no_ratio_of_turns():
    t = np.arange(800) * 0.015
    v, rest = 0.3 * (np.floor(t / 1.5) % 3 - 1), 0 * t
    noise, y = np.random.default_rng(0).normal(0, 0.3, len(t)), np.cumsum(v) * 0.015
    columns = {"t": t, "v1": v, "omega": noise, "x": rest, "y": y, "theta": rest}
    samples = motion_of(log := of_columns("log", columns), paper(), "v1", ("v1", "omega"))

    way, turn = lint.pose_ratios(log, samples)

    assert way == pytest.approx(1.0, abs=0.02)
    assert math.isnan(turn)
    lint.check_poses("log", log, samples)


def test_poses_tell_the_size_of_the_wheels(posed):
    known = KNOWN | {"robot.r": 1.0, "robot.l": 1.0}
    log = of_columns("log", posed)

    r, turn = lint.pose_ratios(log, motion_of(log, override(paper(), known), COUNTS.name))

    assert (r, r / turn) == pytest.approx((TRUTH.r, TRUTH.l), rel=0.02)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "text, word",
    [
        ("t [s],wheel_counts[1] [1]\n1,1\n", "belong together"),
        ("time [s],v1 [m/s]\n1,1\n", "named t"),
        ("t [s],v1 [kg],omega [rad/s]\n1,1,1\n", "does not fit it"),
        ("t [s],v1 [m/s],omega [rad/s]\n", "no rows"),
        ("t,v1,omega\n1,2\n2,3\n", "line 2: it has another number of cells than the 3"),
        ("t,v1,omega\n1,2,\n2,3,fast\n", 'line 3, column omega: "fast" is not a number'),
    ],
)
def test_tables_are_checked_and_nothing_else_is_printed(tmp_path, text, word):
    (tmp_path / "log.csv").write_text(text)

    with pytest.raises(LogError, match=word):
        identify(tmp_path / "log.csv")


UNITS = """
    t | v1 omega | ms | 1e3
    t | v1 omega | us | 1e6
    t | v1 omega | ns | 1e9
    x | y theta | mm | 1e3
    x | y theta | cm | 1e2
    theta | x y | deg | 57.29577951308232
    omega | v1 | deg/s | 57.29577951308232
    v1 | omega | mm/s | 1e3
    wheel_speed[1] | wheel_speed[2] | rpm | 9.549296585513721
    wheel_counts[1] | wheel_counts[2] | ticks | 1
    tau_right | tau_left | N.mm | 1e3
    tau_right | tau_left | Nm | 1
    current_right | current_left | mA | 1e3
    voltage_right | voltage_left | mV | 1e3
"""


@pytest.mark.parametrize("name, others, unit, number", cases(UNITS))
def test_a_size_is_the_same_in_every_unit(name, others, unit, number):
    rest = others.split() if name == "t" else ["t", *others.split()]
    columns = {key: [0.0, 1.0] for key in rest} | {f"{name} [{unit}]": [0.0, float(number)]}

    read = of_columns("log", columns)

    values = read.times["v1"] if name == "t" else read.columns[name]
    assert values.tolist() == pytest.approx([0.0, 1.0], rel=1e-15)


def test_factors_between_units_are_told_within_eight_per_cent_of_them():
    for factor, sense in FACTORS.items():
        for near in (0.96, 1.0, 1.04):
            assert unit_of(near * factor) == sense
            assert unit_of(1 / (near * factor)) == " for ".join(reversed(sense.split(" for ")))
        assert unit_of(0.8 * factor) is unit_of(1.2 * factor) is None


@pytest.mark.parametrize("constant", [0.0, -1.0, math.inf, math.nan])
def test_a_torque_per_ampere_is_positive_and_finite(constant):
    log = of_columns("log", {"t": [0.0], "current_right": [1.0], "current_left": [2.0]})

    with pytest.raises(ArgumentError, match="positive and finite"):
        with_torques(log, constant)
    with pytest.raises(ArgumentError, match="resistance is for voltage_right or"):
        with_torques(log, 1.0, 2.0)


@pytest.mark.parametrize(
    "name, known, factor", [("current", (0.5,), 0.5), ("voltage", (3.0, 2.0), 1.5)]
)
def test_currents_and_voltages_are_torques_once_the_motor_is_known(name, known, factor):
    log = of_columns("log", {"t": [0.0], f"{name}_right": [1.0], f"{name}_left": [2.0]})

    with pytest.raises(LogError, match="--torque-constant"):
        with_torques(log, None)
    read = with_torques(log, *known)

    assert read.pair(TORQUES)[1].tolist() == [[factor, 2 * factor]]
    (said,) = read.remarks
    assert f"torques are {name}_right and {name}_left times {factor:g}" in said
    assert ("viscous friction" in said) is (name == "voltage")


def test_the_smallest_step_of_an_angle_is_a_count_and_rounding_is_none():
    turn = 2 * np.pi * np.array([0, 3, 5, 5, 6]) / 500 + [0, 0, 0, 1e-12, 0]
    log = of_columns("log", {"t [s]": range(5), "wheel_angle[1]": turn, "wheel_angle[2]": turn})

    read, counts = with_counts(log, None)

    assert counts == 500
    assert read.columns[RIGHT] == pytest.approx([0, 3, 5, 5, 6])


def test_wheels_of_a_body_move_it_and_turn_it():
    assert wheels(np.array([[0.4, 1.0]]), 0.15) == pytest.approx(np.array([[0.55, 0.25]]))
