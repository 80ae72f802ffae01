"""The hand-written C is the floor of every benchmark, so it must be right before it is fast."""

import subprocess
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.drive import in_place
from benchmarks.hand_c import HandC
from benchmarks.inputs import mixed_rows, tracking_rows
from benchmarks.native import HERE, floor_toolchain
from benchmarks.numpy_loop import closed_loop
from benchmarks.numpy_step import NumpyLaws
from benchmarks.setup import Case, Setup
from wmr_ctrl.core.errors import CompilerError

try:
    floor_toolchain()
except CompilerError as missing:
    pytest.skip(str(missing), allow_module_level=True)

TOLERANCE = 1e-11


@pytest.fixture(scope="module")
def hand():
    return HandC()


def parts(row):
    return row[:7], row[7:10], row[10:]


def test_network_step_equals_numpy_with_any_weights(hand):
    laws, rng = NumpyLaws(Setup()), np.random.default_rng(2)
    for row in [*tracking_rows(64), *mixed_rows(500, seed=1)]:
        W = rng.normal(0, 100, (2, 64))
        mine = W.ravel().copy()
        expected, W_expected = laws.nn_step(*parts(row), W)
        actual = hand.step("nn", *parts(row), mine)

        np.testing.assert_allclose(actual, expected, rtol=TOLERANCE, atol=TOLERANCE)
        np.testing.assert_allclose(mine, W_expected.ravel(), rtol=TOLERANCE, atol=TOLERANCE)


@pytest.mark.parametrize("law, noise", [("mb", 0.0), ("nn", 1.0)])
def test_closed_loop_equals_a_plain_python_loop(hand, law, noise):
    case = Case(duration=5.0, t_change=2.0, noise_std=noise, seed=4)
    state, fastest, violations = closed_loop(law, Setup(), case)
    result, _ = hand.loop(law, case)

    np.testing.assert_allclose(list(result.state), state, rtol=0, atol=TOLERANCE)
    np.testing.assert_allclose(list(result.max_abs_v), fastest, rtol=0, atol=TOLERANCE)
    assert (result.violations, result.steps) == (violations, 5000)


def test_monitor_counts_the_start_and_stops_a_run_that_diverges(hand):
    outside = Case(initial=(0.0, 0.0, 0.0, 1.3, 2.0), duration=0.01, noise_std=0.0)
    lost = replace(outside, initial=(0.0, 0.0, 0.0, 0.0, 999.0), noise_std=1e6, duration=1.0)
    nowhere = replace(outside, initial=(0.0, 0.0, 0.0, float("nan"), 0.0))

    assert hand.loop("mb", outside)[0].violations == closed_loop("mb", Setup(), outside)[2] > 0
    assert hand.loop("mb", lost)[0].steps < 1000
    assert hand.loop("mb", nowhere)[0].steps == 0


def test_drivers_take_the_same_steps_as_the_library(hand):
    rows, W = tracking_rows(16), np.zeros(128)
    expected = sum(hand.step("nn", *parts(rows[i % 16]), W).sum() for i in range(100))
    state = hand.driven_state("nn")
    driven = in_place(hand.library.hand_nn_driven, rows, state, 2)(100)
    repeated = hand.library.hand_nn_repeat(hand.law, 100, rows, 16, np.zeros(128))

    assert [driven, repeated] == pytest.approx([expected] * 2, rel=1e-12)
    np.testing.assert_array_equal(state[-128:], W)


def test_c_has_no_warnings(tmp_path):
    warnings = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror"]
    command = [*floor_toolchain().command, *warnings, "-O3", "-c"]
    for source in (HERE / "hand" / "hand.c", HERE / "drive.c"):
        out = ["-o", str(tmp_path / f"{source.stem}.o"), str(source)]
        done = subprocess.run([*command, *out], capture_output=True, text=True, check=False)

        assert (done.returncode, done.stderr) == (0, "")
