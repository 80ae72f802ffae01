"""The hand-written C is the floor of every benchmark, so it must be right before it is fast."""

import subprocess
from dataclasses import replace

import mpmath as mp
import numpy as np
import pytest

from benchmarks.drive import in_place
from benchmarks.hand_c import HandC
from benchmarks.inputs import mixed_rows, tracking_rows
from benchmarks.layout import noise_key
from benchmarks.native import HERE, floor_toolchain
from benchmarks.numpy_loop import closed_loop
from benchmarks.numpy_step import NumpyLaws
from benchmarks.setup import Case, Setup
from tests.control.barrier.test_stable import close, exact, points
from wmr_ctrl.core.errors import CompilerError

try:
    floor_toolchain()
except CompilerError as missing:
    pytest.skip(str(missing), allow_module_level=True)

TOLERANCE = 1e-11
ROWS = {"tracking": tracking_rows(64), "mixed": mixed_rows(3000, seed=1)}


@pytest.fixture(scope="module")
def hand():
    return HandC()


def parts(row):
    return row[:7], row[7:10], row[10:]


@pytest.mark.parametrize("rows", ROWS)
@pytest.mark.slow_but("tracking")
def test_network_step_equals_numpy_with_any_weights(hand, rows):
    laws, rng = NumpyLaws(Setup()), np.random.default_rng(2)
    for row in ROWS[rows]:
        W = rng.normal(0, 100, (2, 64))
        mine = W.ravel().copy()
        expected, W_expected = laws.nn_step(*parts(row), W)
        actual = hand.step("nn", *parts(row), mine)

        np.testing.assert_allclose(actual, expected, rtol=TOLERANCE, atol=TOLERANCE)
        np.testing.assert_allclose(mine, W_expected.ravel(), rtol=TOLERANCE, atol=TOLERANCE)


def test_baselines_follow_their_definitions(hand):
    setup, laws, rows = Setup(), NumpyLaws(Setup()), ROWS["mixed"][:50]
    memory, estimates, z_old = np.zeros(3), np.zeros(4), None
    m_hat, F_hat = np.zeros(2), np.zeros(2)
    for row in rows:
        c, c_dot = laws.auxiliary(*parts(row))
        z, shape = row[10:] - c, np.tanh(row[10:] / setup.smc_v_s)
        rate = 0 * z if z_old is None else (z - z_old) / setup.period
        pid = laws.wheels @ (-np.array(setup.pid_kp) * z - np.array(setup.pid_kd) * rate)
        pull = np.array(setup.smc_k) * -z
        pull += np.array(setup.smc_eta) * np.clip(-z / setup.smc_width, -1, 1)
        smc = laws.wheels @ (m_hat * c_dot + F_hat * shape + pull)
        step = setup.period * np.array(setup.smc_weight) * -z
        m_hat = m_hat + step * setup.smc_gain_m * c_dot
        F_hat = F_hat + step * setup.smc_gain_f * shape
        z_old = z

        np.testing.assert_allclose(hand.step("pid", *parts(row), memory), pid, rtol=1e-10)
        np.testing.assert_allclose(hand.step("smc", *parts(row), estimates), smc, rtol=1e-10)
        np.testing.assert_allclose(estimates, [*m_hat, *F_hat], rtol=1e-10)


def test_noise_is_numpys_philox_block_for_block(hand):
    key = noise_key(7)
    for counter in ([1, 0, 0, 0], [79_999, 0, 0, 0], [5, 2, 3, 0]):
        number = sum(word << (64 * i) for i, word in enumerate(counter))
        expected = np.random.Philox(key=key, counter=number - 1).random_raw(4)

        np.testing.assert_array_equal(hand.philox(key, counter), expected)


@pytest.mark.parametrize("law, noise", [("mb", 0.0), ("nn", 1.0)])
def test_closed_loop_equals_a_plain_python_loop(hand, law, noise):
    case = Case(duration=5.0, t_change=2.0, noise_std=noise, seed=4)
    state, fastest, violations = closed_loop(law, Setup(), case)
    result, _ = hand.loop(law, case)

    np.testing.assert_allclose(list(result.state), state, rtol=0, atol=TOLERANCE)
    np.testing.assert_allclose(list(result.max_abs_v), fastest, rtol=0, atol=TOLERANCE)
    assert result.violations == violations
    assert result.steps == 5000


def test_monitor_counts_the_start_and_stops_a_run_that_diverges(hand):
    outside = Case(initial=(0.0, 0.0, 0.0, 1.3, 2.0), duration=0.01, noise_std=0.0)
    lost = replace(outside, initial=(0.0, 0.0, 0.0, 0.0, 999.0), noise_std=1e6, duration=1.0)
    nowhere = replace(outside, initial=(0.0, 0.0, 0.0, float("nan"), 0.0))

    assert hand.loop("mb", outside)[0].violations == closed_loop("mb", Setup(), outside)[2] > 0
    assert hand.loop("pid", lost)[0].steps < 1000
    assert hand.loop("mb", nowhere)[0].steps == 0


def test_drivers_take_the_same_steps_as_the_library(hand):
    rows, W = tracking_rows(16), np.zeros(128)
    expected = sum(hand.step("nn", *parts(rows[i % 16]), W).sum() for i in range(100))
    state = hand.driven_state("nn")
    driven = in_place(hand.library.hand_nn_driven, rows, state, 2)(100)
    repeated = hand.library.hand_nn_repeat(hand.law, 100, rows, 16, np.zeros(128))

    assert driven == pytest.approx(expected, rel=1e-12)
    assert repeated == pytest.approx(expected, rel=1e-12)
    np.testing.assert_array_equal(state[-128:], W)


def test_c_has_no_warnings(tmp_path):
    warnings = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror"]
    command = [*floor_toolchain().command, *warnings, "-O3", "-c"]
    for source in (HERE / "hand" / "hand.c", HERE / "drive.c"):
        out = ["-o", str(tmp_path / f"{source.stem}.o"), str(source)]
        done = subprocess.run([*command, *out], capture_output=True, text=True, check=False)

        assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("axis", [0, 1])
def test_barrier_is_exact_in_every_region(hand, axis):
    """w, V1/A and q, and their limits where the velocity is its target."""
    u1, u2 = Setup().v_u1[axis], Setup().v_u2[axis]
    with mp.workdps(50):
        for c, v in points(u1, u2, 1500, 1e-3):
            quotient, q, target, _ = exact(c, v, u1, u2)
            found = hand.barrier(axis, v, c)
            assert all(map(close, found.tolist(), (v - target, quotient, q))), (c, v, found)
