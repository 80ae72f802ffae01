"""Faults that logs have are told by name, before anything is fitted; good logs are not accused."""

from __future__ import annotations

import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks.own_plant import log_of
from tests.identification.conftest import KNOWN, POSED, TRUTH
from wmr_ctrl.cli import root
from wmr_ctrl.identification import identify
from wmr_ctrl.logs import lint
from wmr_ctrl.logs.log import LogError, of_columns
from wmr_ctrl.logs.samples import motion_of
from wmr_ctrl.scenario import Scenario, override
from wmr_ctrl.world.encoder import COUNTS

T, RIGHT, LEFT = "t [s]", "wheel_counts[1] [1]", "wheel_counts[2] [1]"
TAU, TAU_LEFT = "tau_right [N.m]", "tau_left [N.m]"
X, Y, THETA = "x [m]", "y [m]", "theta [rad]"


def put(log, **changes):
    return {**log, **{globals()[key]: value for key, value in changes.items()}}


def later(values, rows):
    return np.concatenate((np.full(rows, values[0]), values[:-rows]))


def in_row(log, row, name, value):
    return put(log, **{name: np.where(np.arange(len(log[T])) == row, value, log[globals()[name]])})


def drifting(log):
    slow = log[T] + 0.008 * (log[T] - log[T][0])
    return put(
        log,
        **{
            key: np.interp(log[T], slow, log[globals()[key]])
            for key in ("RIGHT", "LEFT", "X", "Y", "THETA")
        },
    )


def reset(log):
    at = len(log[T]) // 2
    return put(log, RIGHT=np.concatenate((log[RIGHT][:at], log[RIGHT][at:] - log[RIGHT][at])))


def wrapped_at(bits):
    half = 2 ** (bits - 1)
    return lambda log: put(log, RIGHT=(log[RIGHT] + half) % (2 * half) - half)


CORRUPTIONS = {
    "not a number": (lambda log: in_row(log, 300, "RIGHT", np.nan), "not numbers"),
    "time goes back": (lambda log: put(log, T=np.where(log[T] > 12, log[T] - 5, log[T])), "back"),
    "time twice": (lambda log: in_row(log, 500, "T", log[T][499]), "time of the row before"),
    "milliseconds": (lambda log: put(log, T=1e3 * log[T]), "milliseconds"),
    "microseconds": (lambda log: put(log, T=1e6 * log[T]), "microseconds"),
    "nanoseconds": (lambda log: put(log, T=1e9 * log[T]), "nanoseconds"),
    "few rows": (lambda log: {k: v[:40] for k, v in log.items()}, "rows"),
    "short": (lambda log: {k: v[:300] for k, v in log.items()}, "too short"),
    "standing": (lambda log: put(log, RIGHT=0 * log[RIGHT], LEFT=0 * log[LEFT]), "moves in"),
    "counter wraps": (wrapped_at(12), "wraps"),
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
    "clocks drift": (drifting, "drift apart"),
    "degrees": (lambda log: put(log, THETA=np.degrees(log[THETA])), "degrees"),
    "millimetres": (lambda log: put(log, X=1e3 * log[X], Y=1e3 * log[Y]), "millimetres"),
    "quarter counts": (
        lambda log: put(log, RIGHT=np.floor(log[RIGHT] / 4), LEFT=np.floor(log[LEFT] / 4)),
        "counts",
    ),
    "theta reversed": (lambda log: put(log, THETA=-log[THETA]), "reversed"),
    "heading of REP 103": (lambda log: put(log, THETA=log[THETA] + np.pi / 2), "REP 103"),
    "x and y exchanged": (lambda log: put(log, X=log[Y], Y=log[X]), "exchanged"),
}  # fmt: skip


@pytest.mark.parametrize("fault", CORRUPTIONS)
def test_a_fault_is_told_by_name(posed, fault):
    change, word = CORRUPTIONS[fault]
    log = {key: np.asarray(value).tolist() for key, value in change(posed).items()}

    with pytest.raises(LogError, match=word) as told:
        identify(log, overrides=KNOWN)

    assert "\n" not in str(told.value)


def test_good_logs_are_not_accused(driven):
    scenario = override(Scenario(), KNOWN)
    for robot in range(4):
        log = of_columns("log", log_of(driven, robot, POSED))
        lint.check_log(log)
        samples = motion_of(log, scenario, COUNTS.name)
        lint.check_motion("log", samples, TRUTH.l)
        lint.check_torques("log", samples, TRUTH.l)
        lint.check_poses("log", log, samples)


def test_poses_tell_the_size_of_the_wheels(driven):
    log = of_columns("log", log_of(driven, 0, POSED))
    samples = motion_of(
        log, override(Scenario(), KNOWN | {"robot.r": 1.0, "robot.l": 1.0}), COUNTS.name
    )

    r, turn = lint.pose_ratios(log, samples)

    assert r == pytest.approx(TRUTH.r, rel=0.02)
    assert r / turn == pytest.approx(TRUTH.l, rel=0.02)


@pytest.mark.parametrize(
    ("header", "word"),
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


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("rows", "word"), [("", "no rows"), ("1,2\n", "2 numbers in a row")])
def test_tables_are_checked_and_nothing_else_is_printed(tmp_path, rows, word):
    path = tmp_path / "log.csv"
    path.write_text(f"t [s],v1 [m/s],omega [rad/s]\n{rows}")

    with pytest.raises(LogError, match=word):
        identify(path)


def test_the_command_refuses_in_one_paragraph_and_writes_nothing(tmp_path):
    path, out = tmp_path / "log.csv", tmp_path / "mine.toml"
    path.write_text(
        "t [s],v1 [m/s],omega [rad/s],tau_right [N.m],tau_left [N.m]\n" + "0,0,0,0,0\n" * 60
    )

    done = CliRunner().invoke(root, ["identify", str(path), "--out", str(out)])

    assert done.exit_code == 2
    assert done.stderr.startswith("error:")
    assert "Traceback" not in done.stderr
    assert not out.exists()
