"""What acts on the commands of a base that takes velocities, each by its own graph and in a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import casadi as ca
import numpy as np
import pytest

import wmr_ctrl
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.effect import EffectRole
from wmr_ctrl.world.model.evaluate import evaluated
from wmr_ctrl.world.registry import EFFECTS
from wmr_ctrl.world.scenario import Scenario, load_scenario, override

BASE: Mapping[str, Any] = {
    "changes": [],
    "base": {"kind": "velocity"},
    "clock.control": 0.05,
    "clock.duration": 3.0,
    "limits": {"v_u1": [1.0, 2.0], "v_u2": [0.7, 1.4]},
}


def based(**base: Any) -> Scenario:
    given = {**BASE, "base": {"kind": "velocity", **base}}
    return override(load_scenario("paper-simulation-noise-free"), given)


def acting(scenario: Scenario, commands: np.ndarray, draws: Sequence[float] = ()) -> np.ndarray:
    """What one effect makes of commands (N, 2), one for each plant step."""
    system = EFFECTS.present(scenario, EffectRole.COMMAND)[-1].system(scenario)
    graph = system.function("act", [ca.densify(system.update), ca.densify(system.y)])
    state, rows = np.array(system.x0), []
    for number, command in enumerate(commands):
        given = [*command, *([number] if len(system.inputs) > 2 else [])]
        drawn = [[draws[number], 0.0]] if system.draws else []
        state, y = evaluated(graph, given, state, system.p0, *drawn)
        rows.append(y.ravel())
    return np.array(rows)


def test_a_ramp_grows_and_shrinks_at_its_rates_and_never_passes_its_command() -> None:
    wanted = np.repeat([[0.5, 1.0], [-0.4, -2.0], [0.0, 0.0]], 900, axis=0)
    found = acting(based(accel=[1.0, 4.0], decel=[2.0, 8.0]), wanted)
    steps = np.diff(np.vstack((np.zeros((1, 2)), found)), axis=0)
    away = np.sign(steps) == np.sign(found)
    assert (np.abs(steps) <= np.where(away, [1e-3, 4e-3], [2e-3, 8e-3]) + 1e-12).all()
    assert found[[899, 1799, 2699]] == pytest.approx(wanted[[899, 1799, 2699]])
    assert np.abs(found).max(axis=0) == pytest.approx(np.abs(wanted).max(axis=0))


JERKY = {"jerk": [3.0, 40.0]}


def test_a_jerk_limit_bends_the_command_so_much_and_reaches_it_without_passing() -> None:
    wanted = np.repeat([[0.5, 1.0], [-0.4, -2.0], [0.0, 0.0]], 2500, axis=0)
    found = acting(based(**JERKY), wanted)
    bends = np.diff(np.vstack((np.zeros((2, 2)), found)), n=2, axis=0)
    assert (np.abs(bends) <= np.array([3.0, 40.0]) * 1e-6 * (1 + 1e-6)).all()
    assert np.abs(bends).max(axis=0) == pytest.approx(np.array([3.0, 40.0]) * 1e-6, rel=1e-6)
    assert found[[2499, 4999, 7499]] == pytest.approx(wanted[[2499, 4999, 7499]], abs=1e-12)
    assert np.abs(found).max(axis=0) == pytest.approx([0.5, 2.0], rel=1e-12)
    reached = np.argmax(np.isclose(found[:2500, 0], 0.5, rtol=1e-9))
    assert reached * 1e-3 == pytest.approx(2 * (0.5 / 3.0) ** 0.5, rel=0.02)


def test_an_axis_without_limit_is_where_its_command_is() -> None:
    wanted = np.random.default_rng(2).uniform(-1, 1, (300, 2))
    found = acting(based(jerk=[3.0, float("inf")]), wanted)
    assert found[:, 1] == pytest.approx(wanted[:, 1], abs=1e-12)
    assert np.abs(found[:, 0]).max() < 0.1


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.slow_but("0")
def test_whatever_comes_it_stays_between_the_commands_so_far(seed: int) -> None:
    """The hypothesis of the clip, which asks nothing else of a stage of the base."""
    rng = np.random.default_rng(seed)
    held = np.repeat(rng.uniform(-1, 1, (60, 2)), rng.integers(1, 150, 60), axis=0)
    found = acting(based(**JERKY, **({"accel": [0.8, 5.0]} if seed % 2 else {})), held)
    top = np.maximum.accumulate(np.vstack((np.zeros((1, 2)), held)), axis=0)[1:]
    bottom = np.minimum.accumulate(np.vstack((np.zeros((1, 2)), held)), axis=0)[1:]
    assert (found <= top + 1e-12).all()
    assert (found >= bottom - 1e-12).all()
    assert np.abs(found - held).max() > 0.1


def test_a_dead_band_takes_small_commands_for_zero_and_leaves_the_others() -> None:
    wanted = np.array([[0.049, -0.11], [0.051, -0.09], [-0.05, 0.1]])
    assert acting(based(deadband=[0.05, 0.1]), wanted) == pytest.approx(
        np.array([[0.0, -0.11], [0.051, 0.0], [-0.05, 0.1]])
    )


def test_a_quantum_is_off_by_half_a_step_at_most() -> None:
    wanted = np.random.default_rng(0).uniform(-1, 1, (200, 2))
    found = acting(based(quantum=[0.03, 0.0]), wanted)
    assert (found[:, 1] == wanted[:, 1]).all()
    assert np.abs(found[:, 0] - wanted[:, 0]).max() <= 0.015 + 1e-12
    assert found[:, 0] / 0.03 == pytest.approx(np.round(found[:, 0] / 0.03), abs=1e-9)


def test_a_wheel_limit_couples_both_axes_and_lets_neither_grow() -> None:
    wanted = np.random.default_rng(1).uniform(-3, 3, (500, 2))
    found = acting(based(w_max=8.0), wanted)
    wheels = np.column_stack([found @ [1.0, 0.25], found @ [1.0, -0.25]])
    free = np.column_stack([wanted @ [1.0, 0.25], wanted @ [1.0, -0.25]])
    assert wheels == pytest.approx(np.clip(free, -0.8, 0.8))
    assert (np.abs(found) <= np.abs(wanted) + 1e-12).all()
    assert (found * wanted >= -1e-12).all()


def test_commands_are_lost_so_often_in_a_row_and_no_more() -> None:
    sent = np.repeat(np.arange(1.0, 61.0), 50)
    wanted = np.column_stack((sent, -sent))
    found = acting(based(losses=2), wanted, [-1.0] * len(sent))
    heard = np.unique(found[150:, 0])
    assert np.diff(heard) == pytest.approx(3.0)
    assert (found[:100] == 0).all()


def test_a_base_that_hears_nothing_stops_after_its_time_out() -> None:
    wanted = np.full((400, 2), 0.3)
    found = acting(based(losses=100, timeout=0.12), wanted, [1.0] * 50 + [-1.0] * 350)
    assert (found[:121] == 0.3).all()
    assert (found[121:] == 0.0).all()


IN_RUNS: Mapping[str, Mapping[str, Any]] = {
    "ramp": {"accel": [1.0, 3.0]},
    "jerk": {"jerk": [3.0, 9.0]},
    "dead band": {"deadband": [0.2, 0.3]},
    "quantum": {"quantum": [0.03, 0.07]},
    "wheels": {"w_max": 6.0},
    "losses": {"losses": 3, "delay": 0.02},
    "time-out": {"losses": 3, "timeout": 0.06},
}


@pytest.mark.parametrize("name", IN_RUNS)
@pytest.mark.slow_but("losses")
def test_it_acts_in_runs_alike_in_both_engines(name: str) -> None:
    scenario = based(**IN_RUNS[name])
    native, numpy = (wmr_ctrl.simulate(scenario, "kanayama", engine=e) for e in ("native", "numpy"))
    plain = wmr_ctrl.simulate(based(), "kanayama", engine="numpy")
    for column in ("x", "v1", "omega"):
        assert native[column] == pytest.approx(numpy[column], abs=1e-9), column
    assert np.abs(native["v1"] - plain["v1"]).max() > 1e-4


GOVERNOR = {"kind": "governor", "tau": [0.2, 0.2], "delay": [0.02, 0.02]}


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("ramp", "ramps"),
        ("jerk", "rounds"),
        ("dead band", "do not act"),
        ("quantum", "filter.d[1]"),
        ("wheels", "clips"),
        ("losses", "filter.losses"),
        ("time-out", "the base stops"),
    ],
)
def test_a_governor_counts_on_none_of_them_and_a_clip_on_errors_alone(
    name: str, words: str
) -> None:
    broken = based(**{"delay": 0.02, **IN_RUNS[name]})
    with pytest.raises(ScenarioError) as error:
        settle(override(broken, {"filter": {**GOVERNOR, "losses": 3 * (name == "time-out")}}), None)
    assert words in str(error.value)
    push = [0.02, 0.04] if name == "quantum" else [0.0, 0.0]
    settle(override(broken, {"filter": {"kind": "clip", "d": push}}), None)
