"""The limit holds against the worst disturbance, any switching one, any mass and bounded noise."""

from __future__ import annotations

import numpy as np
import pytest

from tests.control.guard.harness import HEAVY, LIGHT, LIMITS, MOST, WIDE, Robot, guarded
from wmr_ctrl.api import simulate
from wmr_ctrl.results import Run

LIGHTEST = {
    **WIDE,
    "robot.m": 25.0,
    "robot.I": 2.7,
    "robot.mu": 0.0,
    "model.m": 50.0,
    "model.I": 5.4,
    "model.mu": 0.08,
    "disturbance.push": [60.0, 15.0],
}
PUSHED_OUT = {"pid", "smc", "mb", "nn"}
"""Laws that an unguarded adversary drives through a limit at every period."""


def pushed(law: str, period: float, guard: bool = True, **changed: object) -> Run:
    overrides = {**LIGHTEST, "clock.control": period, "clock.duration": 10.0, **changed}
    return simulate("paper-simulation-nominal", law, guard=guard, overrides=overrides)


@pytest.mark.parametrize(
    ("law", "period"), [("smc", 0.001), ("prox", 0.01), ("mb", 0.05), ("nn", 0.1)]
)
@pytest.mark.slow
def test_greedy_adversary_reaches_the_limit_and_never_passes_it(law: str, period: float) -> None:
    run = pushed(law, period)

    gap = np.array(run.monitor.max_abs_v) - LIMITS
    assert run.monitor.violations == 0
    assert run.outcome == "completed"
    if law in PUSHED_OUT:
        assert gap.max() > -1e-9
        assert pushed(law, period, guard=False).outcome != "completed"


@pytest.mark.parametrize(
    ("law", "period"), [("pid", 0.01), ("smc", 0.001), ("pid", 0.05), ("smc", 0.1)]
)
@pytest.mark.slow_but("pid-0.01")
def test_a_broken_bound_costs_exactly_its_excess(law: str, period: float) -> None:
    """|d| <= dbar + D gives |v| <= v_u1 + D T/M_min, and the adversary gets there."""
    run = pushed(law, period, **{"guard.dbar": [40.0, 10.0], "guard.trust": True})

    excess = np.array([20.0, 5.0]) * period / LIGHT
    assert run.monitor.max_abs_v == pytest.approx(LIMITS + excess, abs=1e-9)
    assert run.outcome == "limit-violated"


@pytest.mark.parametrize("law", ["pid", "prox"])
@pytest.mark.slow_but("pid")
def test_switching_disturbances_any_mass_and_noise(law: str) -> None:
    """Random cases: bang-bang in time or by sign; mass, friction, nbar, period, start."""
    draw = np.random.default_rng(sum(law.encode()))
    for case in range(6):
        worst = run_case(law, drawn(draw, case), draw)
        assert (worst <= LIMITS * (1 + 1e-14)).all(), (law, case, worst - LIMITS)


@pytest.mark.slow
def test_searched_disturbances() -> None:
    """A hill climb over period, phase, mass, friction and start finds nothing beyond the limit."""
    draw = np.random.default_rng(7)
    best, worst = None, -np.inf
    for step in range(30):
        case = drawn(draw, 1 + 2 * (step % 3)) if step < 15 else moved(draw, best)
        found = (run_case("pid", case, draw) / LIMITS).max()
        if found > worst:
            best, worst = case, found
    assert worst <= 1 + 1e-14


def drawn(draw: np.random.Generator, case: int) -> dict[str, object]:
    return {
        "period": (0.01, 0.05, 0.1)[case % 3],
        "nbar": np.array([0.02, 0.03]) * (case % 2),
        "half": draw.uniform(0.05, 2.0, 2),
        "by_sign": draw.random() < 0.4,
        "phase": draw.uniform(0, 1, 2),
        "mass": draw.choice([LIGHT, HEAVY, draw.uniform(LIGHT, HEAVY)]),
        "friction": np.array([draw.choice([0.0, 40.0, 90.0]), draw.choice([0.0, 2.0])]),
        "v": LIMITS * draw.uniform(-1, 1, 2),
        "pose": draw.uniform(-3, 3, 3),
    }


def moved(draw: np.random.Generator, case: dict[str, object]) -> dict[str, object]:
    """A neighbour of a case."""
    near = {key: case[key] * draw.uniform(0.8, 1.25, 2) for key in ("half", "friction")}
    near["phase"] = case["phase"] + draw.normal(size=2) * 0.1
    near["mass"] = np.clip(case["mass"] * draw.uniform(0.9, 1.1, 2), LIGHT, HEAVY)
    near["v"] = np.clip(case["v"] + draw.normal(size=2) * 0.1, -LIMITS, LIMITS)
    near["pose"] = case["pose"] + draw.normal(size=3) * 0.3
    return {**case, **near}


def run_case(law: str, case: dict[str, object], draw: np.random.Generator) -> np.ndarray:
    nbar = case["nbar"]

    rhythm = list(zip(case["half"].tolist(), case["phase"].tolist(), strict=True))

    def switching(t: float, v: np.ndarray) -> np.ndarray:
        if case["by_sign"]:
            return MOST * [-1.0 if x < 0 else 1.0 for x in v.tolist()]
        return MOST * [1.0 if (t / half + phase) % 2 < 1 else -1.0 for half, phase in rhythm]

    robot = Robot(
        mass=case["mass"],
        friction=case["friction"],
        disturbance=switching,
        error=lambda: nbar * draw.choice([-1.0, 1.0, draw.uniform(-1, 1)], 2),
        v=case["v"].copy(),
        pose=case["pose"].copy(),
    )
    scenario = guarded(case["period"], **{"guard.nbar": nbar.tolist()})
    return abs(robot.drive(law, scenario, int(3.0 / case["period"]))).max(axis=0)
