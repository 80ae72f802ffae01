"""The plant behind late drives and sensors, against forces followed one by one."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st

from wmr_ctrl.api import simulate
from wmr_ctrl.checks import stability
from wmr_ctrl.checks.lateness import Lateness
from wmr_ctrl.checks.sampled_plant import drives, sampled_plant
from wmr_ctrl.linear.report import report_linear
from wmr_ctrl.scenario import load_scenario

TICK = 1e-3
RATES = np.array([
    [0.0, 0.1, 0, -1, 0], [-0.1, 0, 0.2, 0, 0], [0, 0, 0, 0, -1], [0, 0, 0, -0.3, 0],
    [0, 0, 0, 0.2, -0.5],
])  # fmt: skip
PUSH = np.array([[0.0, 0], [0, 0], [0, 0], [0.02, 0], [0.01, 0.2]])


def followed(period: int, late: Lateness, commands: np.ndarray, push: np.ndarray):
    """Measured (N, 5) and mean force (N, 2), tick by tick; ``period`` counts ticks.

    Behind the robot stand the lag, the integral of the force that acts and that of both velocities.
    """
    lag, n = (2 if late.lag else 0), (7 if late.lag else 5)
    rates, held = np.zeros((n + 4, n + 4)), np.zeros((n + 4, 4))
    rates[:5, :5], held[:5, 2:], rates[n + 2 :, 3:5] = RATES, PUSH, np.eye(2)
    if lag:
        rates[:5, 5:7], rates[5:7, 5:7], rates[7:9, 5:7] = PUSH, -np.eye(2) / late.lag, np.eye(2)
        held[5:7, :2] = np.eye(2) / late.lag
    else:
        held[:5, :2], held[5:7, :2] = PUSH, np.eye(2)
    block = np.zeros((n + 8, n + 8))
    block[: n + 4, : n + 4], block[: n + 4, n + 4 :] = rates, held
    step, shift = scipy.linalg.expm(block * TICK), round(late.delay / TICK)
    states = [np.zeros(n + 4)]
    for tick in range(period * len(commands)):
        due = (tick - shift) // period
        command = commands[due] if due >= 0 else np.zeros(2)
        states.append((step @ np.concatenate((states[-1], command, push)))[: n + 4])
    path = np.array(states)
    shown = path[::period, :5].copy()
    for axis in (0, 1):
        age, window = round(late.age[axis] / TICK), round(late.window[axis] / TICK)
        for k in range(len(shown)):
            last, first = max(k * period - age, 0), max(k * period - age - window, 0)
            way = path[last, n + 2 + axis] - path[first, n + 2 + axis]
            shown[k, 3 + axis] = way / window / TICK if window else path[last, 3 + axis]
    means = np.diff(path[::period, n : n + 2], axis=0) / (period * TICK)
    return shown[:-1], np.vstack((np.zeros((1, 2)), means[:-1]))


ticks = st.integers(0, 30)


@settings(max_examples=40)
@given(
    period=st.integers(2, 20), delay=ticks, lag=st.sampled_from([0.0, 0.004, 0.03]),
    ages=st.tuples(ticks, ticks), windows=st.tuples(ticks, ticks), seed=st.integers(0, 99),
)  # fmt: skip
def test_every_lateness_is_followed_exactly(period, delay, lag, ages, windows, seed):
    """Whole multiples and fractions of the period, alone and together."""
    late = Lateness(
        delay * TICK, lag, tuple(a * TICK for a in ages), tuple(w * TICK for w in windows)
    )
    draw = np.random.default_rng(seed)
    commands, push = draw.normal(size=(8, 2)), draw.normal(size=2)
    plant = sampled_plant(RATES, PUSH, period * TICK, late, mean=True)
    own = drives(period * TICK, late)
    shown, means = followed(period, late, commands, push)
    x, memory = np.zeros(len(plant.moved)), np.zeros(len(own.moved))
    assert len(plant.names) == len(x) - 5
    for k, command in enumerate(commands):
        assert plant.measured @ x == pytest.approx(shown[k], rel=1e-7, abs=1e-12)
        assert plant.applied @ x == pytest.approx(means[k], rel=1e-7, abs=1e-10)
        assert own.applied @ memory == pytest.approx(plant.applied @ x, rel=1e-12, abs=1e-14)
        x = plant.moved @ x + plant.forced @ command + plant.pushed @ push
        memory = own.moved @ memory + own.forced @ command


FOUR = [(0.1, 0.05), (0.05, 0.05), (0.02, 0.06), (0.01, 0.05)]
PAGES = [("prox", *FOUR[0]), *(pytest.param(law, *each, marks=pytest.mark.slow)
         for each in FOUR for law in ("prox", "kanayama"))]  # fmt: skip


@pytest.mark.parametrize(("law", "period", "delay"), PAGES[:1] + PAGES[2:])
def test_no_figure_of_one_page_contradicts_another(law, period, delay):
    """Unstable by radius, poles, margins, limits of period, delay and mass, or by none of them."""
    late = {"clock.control": period, "actuator.delay": delay}
    scenario = load_scenario("paper-simulation-nominal", late)
    page = report_linear(scenario, law)
    stable = (law, period) in (("kanayama", period), ("prox", 0.1))
    said = [
        page.stable, page.spectral_radius < 1, page.max_sample_time > period,
        page.max_delay is not None and page.max_delay > delay, page.mass_range is not None,
        *(item is not None for item in page.sampled_margins),
    ]  # fmt: skip
    remarks = [item.key for item in simulate(scenario, law).remarks]

    assert said == [stable] * len(said)
    assert page.late
    assert page.margins == page.sampled_margins
    assert ("oscillates" not in remarks) is stable


def cycles(overrides: dict[str, float], law: str) -> bool:
    """Whether a displacement of a tenth of a millimetre grows, on a floor without friction."""
    still = {"robot.mu": 0.0, "model.mu": 0.0, "initial.pose": [1e-4, 0.0, -1.5707],
             "initial.velocity": [0.2, 0.1], "clock.duration": 40.0}  # fmt: skip
    torque = simulate("paper-simulation-nominal", law, overrides=still | overrides)["tau_right"]
    return bool(abs(torque[-50:]).max() > abs(torque[:10]).max())


@pytest.mark.parametrize("law", ["prox", "kanayama"])
def test_runs_cycle_just_outside_the_masses_that_are_said(law):
    period = {"clock.control": 0.1}
    low, high = stability(load_scenario("paper-simulation-nominal", period), law).masses
    for ratio, outside in ((0.9 * low, True), (1.1 * low, False), (0.9 * high, False)):
        robot = {"robot.m": 50.0 * ratio, "robot.I": 5.4 * ratio, "model.m": 50.0, "model.I": 5.4}
        assert cycles(period | robot, law) is outside


@pytest.mark.parametrize("law", ["prox", "kanayama", "pid"])
def test_runs_cycle_just_beyond_the_delay_that_is_said(law):
    period = {"clock.control": 0.05}
    most = stability(load_scenario("paper-simulation-nominal", period), law).delay
    for delay, beyond in ((most - 0.004, False), (most + 0.004, True)):
        late = {"actuator.delay": round(delay, 3)}
        assert cycles(period | late, law) is beyond
