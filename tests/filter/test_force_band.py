"""The band of weak motors: force and speed of every base within their limits, and none without."""

from __future__ import annotations

import itertools
from functools import cache

import numpy as np
import pytest
from scipy.signal import lti, step

import wmr_ctrl
from tests.filter.linear_base import held, pi_base
from tests.filter.test_band import CORNERS, PARTS, T, demands
from tests.filter.test_peak_gain import LOOP, WIDE, scenario
from wmr_ctrl import command_filter
from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.filter.band import MOST_COMMANDS, PIECES
from wmr_ctrl.filter.channels import ROUNDING
from wmr_ctrl.filter.filter import CommandFilter
from wmr_ctrl.filter.force_band import force_room
from wmr_ctrl.filter.gate import GateSettings, gate_system
from wmr_ctrl.filter.step_response import force_band, pi_cells
from wmr_ctrl.scenario import override

WEAK = 120.0
NUMBERS = list(itertools.product(*WIDE.values()))


@cache
def banded(force: float = WEAK, push: float = 0.0) -> CommandFilter:
    return command_filter(scenario(kind="band", force=(force, force / 4), push=(push, 0.0)))


def asked_of(number: int, limit: CommandFilter, asked: np.ndarray, d: float) -> np.ndarray:
    """Speed and force that the loop asks for, (2, instants), motors being as strong as need be."""
    limit.start()
    M, kp, ki, c = NUMBERS[number]
    base = pi_base(M, kp, ki, c)
    A, B = held(base.A, np.c_[base.b, base.e], T / PARTS)
    x, rows = np.zeros(2), []
    for r in asked:
        u = limit.step((r, 0.0)).command[0]
        for _ in range(PARTS):
            rows.append((x[0], kp * (u - x[0]) + x[1]))
            x = A @ x + B @ np.array([u, d * np.sign(r)])
            rows.append((x[0], kp * (u - x[0]) + x[1]))
    return np.abs(rows).T


@pytest.mark.parametrize("number", range(0, 16, 3))
@pytest.mark.parametrize("force", [WEAK, 60.0])
def test_no_corner_of_the_family_passes_its_limit_or_its_force(number, force):
    worst = [asked_of(number, banded(force), r, 0.0).max(axis=1) for r in demands(CORNERS[number],
             number)]  # fmt: skip
    v, F = np.max(worst, axis=0)
    assert v <= 1.0
    assert force >= F


def test_the_strongest_loop_uses_its_force_and_nearly_all_of_its_speed():
    number = NUMBERS.index((65.0, 165.0, 330.0, 20.0))
    v, F = asked_of(number, banded(), np.full(400, 9.0), 0.0).max(axis=1)
    assert F > 0.98 * WEAK
    assert v > 0.99


def test_motors_that_are_five_per_cent_weaker_are_asked_for_more_than_they_give():
    number = NUMBERS.index((65.0, 165.0, 330.0, 20.0))
    assert asked_of(number, banded(), np.full(60, 9.0), 0.0)[1].max() > 0.95 * WEAK


def test_nor_with_the_push_that_is_stated():
    base = CORNERS[0]
    worst = [asked_of(0, banded(push=10.0), r, 10.0).max(axis=1) for r in demands(base, 1)]
    v, F = np.max(worst, axis=0)
    assert v <= 1.0
    assert F <= WEAK


def windup(number: int, limit: CommandFilter, most: float, asked: np.ndarray) -> float:
    """Largest speed of a loop whose integral goes on, its motors giving ``most`` at most."""
    limit.start()
    (M, kp, ki, c), v, f, worst, h = NUMBERS[number], 0.0, 0.0, 0.0, T / 100
    for r in asked:
        u = limit.step((r, 0.0)).command[0]
        for _ in range(100):
            F = float(np.clip(kp * (u - v) + f, -most, most))
            f, v = f + h * ki * (u - v), v + h * (F - c * v) / M
            worst = max(worst, abs(v))
    return worst


def test_a_loop_that_winds_up_passes_the_limit_without_it_and_not_with_it():
    """The plain band counts on motors as strong as need be."""
    number, swings = NUMBERS.index((65.0, 135.0, 330.0, 0.0)), np.repeat([9.0, -9.0] * 4, 25)
    plain = command_filter(scenario(kind="band", push=(0.0, 0.0)))
    assert windup(number, plain, 60.0, swings) > 1.05
    assert windup(number, banded(60.0), 60.0, swings) <= 1.0


def test_a_loop_asks_for_nearly_all_that_is_left():
    number = NUMBERS.index((65.0, 165.0, 330.0, 0.0))
    reached = max(asked_of(number, banded(), r, 0.0)[1].max() for r in demands(CORNERS[number], 2))
    assert reached > 0.98 * WEAK


def test_a_stop_comes_by_a_ramp_and_comes():
    limit = banded()
    limit.start()
    up = [limit.step((9.0, 0.0)).command[0] for _ in range(200)]
    down = [limit.step((0.0, 0.0)).command[0] for _ in range(60)]
    assert up[-1] > 0.99
    assert down[0] > 0.0
    assert (np.diff(down) <= 1e-12).all()
    assert down[-1] == 0.0


def test_it_is_odd_and_sends_what_it_may_as_it_came():
    asked = np.random.default_rng(6).uniform(-1, 1, (60, 2))
    sent = []
    for way in (1, -1):
        banded().start()
        sent.append([banded().step(tuple(way * r)).command for r in asked])
    assert np.array_equal(np.array(sent[0]), -np.array(sent[1]))
    banded().start()
    assert banded().step((0.1, 0.02)).command == (0.1, 0.02)


def test_tables_hold_the_force_of_every_member_and_little_more():
    known = force_band(pi_cells(LOOP), T, PIECES, MOST_COMMANDS)
    t = np.arange(4 * len(known.low) + 1) * T / PIECES / 4
    forces = []
    for M, kp, ki, c in itertools.product((50, 57, 65), (135, 165), (270, 330), (0, 7, 20)):
        _, S = step(lti([kp, ki], [M, kp + c, ki]), T=t)
        pull = kp * (1 - S) + ki * np.r_[0, np.cumsum(1 - (S[1:] + S[:-1]) / 2)] * t[1]
        forces.append(pull - c * S)
    pieces = np.stack([np.array(forces)[:, k : k + len(t) - 1 : 4] for k in range(5)])
    assert (pieces.max(axis=(0, 1)) <= known.high + 1e-3).all()  # the trapezoidal rule's
    assert (pieces.min(axis=(0, 1)) >= known.low - 1e-3).all()
    assert (known.high - pieces.max(axis=(0, 1))).max() < 0.08 * 165
    assert (pieces.min(axis=(0, 1)) - known.low)[1:].max() < 0.08 * 165
    assert known.low[0] == 0.0  # before the step there is no force
    assert known.high[0] == pytest.approx(165.0, rel=0.01)


def test_what_is_left_of_the_force_is_less_what_pushes_take():
    stated = scenario(kind="band", force=(120.0, 40.0), push=(10.0, 0.0))
    left = force_room(stated)
    kept = 1 - ROUNDING
    assert left[0] == pytest.approx(120.0 * kept - LOOP.peak(0.0).gain * 10.0, rel=1e-9)
    assert left[1] == pytest.approx(40.0 * kept, rel=1e-12)


@pytest.mark.parametrize(
    ("stated", "words"),
    [
        ({"force": (20.0, 40.0)}, "leaves nothing to change the speed with: friction"),
        ({"force": (120.0, 40.0), "kind": "clip"}, "filter.force is for"),
        ({"force": (120.0, 40.0), "loop": "second-order", "frequency": (3.0, 5.0),
          "damping": (0.4, 1.4)}, "filter.force is for"),
    ],
)  # fmt: skip
def test_a_force_that_cannot_be_counted_on_is_refused(stated, words):
    with pytest.raises(ScenarioError, match=words):
        command_filter(scenario(**({"kind": "band", "push": (0.0, 0.0)} | stated)))


def test_a_gate_which_stops_at_once_refuses_it():
    with pytest.raises(ScenarioError, match=r"filter\.force: a gate sends 0 at once"):
        gate_system(scenario(kind="band", push=(0.0, 0.0), force=(120.0, 40.0)), GateSettings())


def test_a_run_of_weak_motors_is_kept_and_one_of_weaker_ones_refused():
    base = {
        "base.kind": "velocity", "base.loop": "pi", "base.antiwindup": False, "robot.m": 60.0,
        "robot.I": 60 / 16, "robot.mu": 0.0, "disturbance.std": 0.0, "changes": [],
        "limits.v_u1": (1.0, 1.0), "clock.duration": 6.0, "initial.pose": [-2.0, -2.0, -0.7],
    }  # fmt: skip
    stated = override(scenario(kind="band", push=(0.0, 0.0), force=(60.0, 15.0)), base)
    r, l = stated.robot.r, stated.robot.l
    enough = r * (60.0 + 15.0 / l) / 2
    run = wmr_ctrl.simulate(override(stated, {"actuator.tau_max": enough}), "kanayama",
                            engine="numpy")  # fmt: skip
    assert run.monitor.violations == 0
    assert np.abs(run["tau_right"]).max() < enough
    assert np.abs(run["v1"]).max() > 0.3
    with pytest.raises(ScenarioError, match="may ask a wheel for"):
        wmr_ctrl.simulate(override(stated, {"actuator.tau_max": 0.95 * enough}), "kanayama")


@pytest.mark.parametrize("push", [0.0, 10.0])
def test_a_step_takes_no_more_of_weak_motors_than_the_proof_of_rounding_counts_on(push):
    """`filter.rounding.force`: A c <= 2^8 f, and drag c <= f."""
    numbers = {item.signal.name: item.value for item in banded(60.0, push).system.params}
    for i, name in enumerate(("v", "omega")):
        c, f = (1, 1)[i] * 1.0, numbers["filter.force_room"][i]
        sizes = (numbers[f"filter.{end}_force_{name}"] for end in ("above", "below"))
        assert max(abs(np.asarray(size)).max() for size in sizes) * c <= 2.0**8 * f
        assert numbers["filter.drag"][i] * c <= f
