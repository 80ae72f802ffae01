"""The guard's own graph: box, maps, monitor, and its generated C in exact arithmetic."""

from __future__ import annotations

import math
from fractions import Fraction

import casadi as ca
import numpy as np
import pytest

from tests.codegen.compiled import compiled
from tests.oracle.guard import VelocityGuard, axes_of
from wmr_ctrl.codegen.emit import kernel
from wmr_ctrl.control.controller import guard
from wmr_ctrl.control.guard.guard import MAPS, Bounds, ceiling, clipped, feasible, floor
from wmr_ctrl.control.guard.monitor import least_push
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.model.system import System
from wmr_ctrl.world.scenario import load_scenario

NAMES = ("u1", "period", "M_min", "M_max", "dbar", "nbar", "alpha", "brake", "f_min", "f_speed")
BOUNDS = Bounds(**{name: ca.SX.sym(name) for name in NAMES})
SYMBOLS = ca.vertcat(*(getattr(BOUNDS, name) for name in NAMES))
ASKED, Y = ca.SX.sym("asked"), ca.SX.sym("y")
ONE_AXIS = ca.Function("axis", [ASKED, Y, SYMBOLS], [clipped(ASKED, Y, BOUNDS)])
BOX = ca.Function("box", [Y, SYMBOLS], [floor(Y, BOUNDS), ceiling(Y, BOUNDS), feasible(BOUNDS)])
SHRUNK = 1 - 2.0**-44


def drawn(draw: np.random.Generator) -> tuple[np.ndarray, float]:
    """Feasible numbers of one axis in the order of NAMES, and the limit that they serve."""
    u1, period = 10 ** draw.uniform(-1, 1), 10 ** draw.uniform(-3.5, 0)
    low = 10 ** draw.uniform(-1, 2.5)
    high = low * draw.uniform(1, 4)
    alpha = draw.choice([1.0, draw.uniform(0.05, 1.0)]) / period
    f_speed = u1 * draw.choice([0.0, draw.uniform(0, 0.4)])
    most = low * alpha * (u1 * SHRUNK - f_speed) / 2
    net = most * draw.choice([1 - 1e-12, draw.uniform(0, 1), 0.0])
    f_min = net * draw.choice([0.0, draw.uniform(0, 1)])
    brake = draw.choice([1e30, net + (2 * most - 2 * net) * draw.uniform(0, 1)])
    nbar = u1 / 2 * draw.choice([0.0, draw.uniform(0, 0.999)])
    numbers = (u1 * SHRUNK, period, low, high, net + f_min, nbar, alpha, brake, f_min, f_speed)
    return np.array(numbers), u1


def speed(draw: np.random.Generator, u1: float) -> float:
    """A true speed inside the limit: often within a few units in the last place of it."""
    edge = u1 * (1 - 2.0**-52 * draw.integers(0, 4)) * draw.choice([-1, 1])
    return float(draw.choice([edge, draw.uniform(-u1, u1), 0.0, u1]))


def worst_speed(row: np.ndarray, force: float, v: float) -> Fraction:
    """Largest |v| that any mass, friction and disturbance reach within the sample, exactly."""
    n = {name: Fraction(float(value)) for name, value in zip(NAMES, row, strict=True)}
    reached = []
    for way in (1, -1):
        pushed = way * Fraction(force) + n["dbar"] - n["f_min"]
        start = max(way * Fraction(v), n["f_speed"])
        reached.append(start + n["period"] * max(pushed, Fraction(0)) / n["M_min"])
    return max(reached)


@pytest.mark.slow
def test_generated_c_keeps_the_limit_in_exact_arithmetic() -> None:
    item = kernel(
        "axis", "One axis of the guard.",
        {"asked": ASKED, "y": Y, "p": SYMBOLS}, {"force": clipped(ASKED, Y, BOUNDS)},
    )  # fmt: skip
    step, draw = compiled([item])[0], np.random.default_rng(0)
    for _ in range(3000):
        row, u1 = drawn(draw)
        v = speed(draw, u1)
        y = v + row[5] * draw.choice([-1, 1, 0]) * (1 - 2.0**-50)
        asked = draw.choice([math.inf, -math.inf, 0.0, draw.normal() * row[2] * row[6] * u1])
        force = float(step(np.array([asked]), np.array([y]), row)[0])
        assert worst_speed(row, force, v) <= Fraction(u1), (row.tolist(), v, y, asked, force)


def test_box_is_never_empty() -> None:
    draw = np.random.default_rng(2)
    for _ in range(3000):
        row, u1 = drawn(draw)
        low, high, possible = (float(item) for item in BOX(draw.normal() * u1, row))
        assert low <= high
        assert possible == 1.0


@pytest.mark.parametrize(
    ("name", "value"),
    [("dbar", 1e9), ("nbar", 0.51), ("alpha", 100.1), ("brake", 5.0), ("M_max", 1.0)],
)
def test_bounds_that_cannot_be_met_are_flagged(name: str, value: float) -> None:
    row = np.array([1.0, 0.01, 45.0, 70.0, 60.0, 0.0, 100.0, 400.0, 0.0, 0.0])
    assert float(BOX(0.0, row)[2]) == 1.0
    row[NAMES.index(name)] = value
    assert float(BOX(0.0, row)[2]) == 0.0


def test_a_force_that_is_no_number_becomes_a_safe_one() -> None:
    row = np.array([1.0, 0.01, 45.0, 70.0, 60.0, 0.0, 100.0, 400.0, 0.0, 0.0])
    low, high, _ = (float(item) for item in BOX(0.9, row))

    assert low <= float(ONE_AXIS(math.nan, 0.9, row)) <= high


def test_safe_force_inside_the_box_is_left_alone() -> None:
    row = np.array([1.0, 0.01, 45.0, 70.0, 60.0, 0.0, 100.0, 1e30, 0.0, 0.0])

    assert float(ONE_AXIS(123.456, 0.3, row)) == 123.456


@pytest.mark.parametrize("name", MAPS)
def test_maps_end_in_the_box_and_in_reach_and_a_clip_per_wheel_does_not(name: str) -> None:
    draw, half, left = np.random.default_rng(3), 0.25, 0
    force, safe, phi = ca.SX.sym("f", 2), ca.SX.sym("s", 2), ca.SX.sym("phi")
    mapped = ca.Function("map", [force, safe, phi], [MAPS[name](force, phi, ca.SX(half), safe)])
    for _ in range(2000):
        corner, reach = np.sort(draw.normal(size=(2, 2)) * (100, 25), axis=0), 150.0
        near = np.clip(0.0, corner[0], corner[1])
        if abs(near[0]) + abs(near[1]) / half > reach:
            continue
        asked = draw.uniform(corner[0], corner[1])
        found = mapped(asked, near, reach).full().ravel()
        assert (found >= corner[0] - 1e-12).all()
        assert (found <= corner[1] + 1e-12).all()
        assert abs(found[0]) + abs(found[1]) / half <= reach * (1 + 1e-15)
        wheels = np.clip([asked[0] + asked[1] / half, asked[0] - asked[1] / half], -reach, reach)
        clipped_force = np.array([wheels.sum(), half * (wheels[0] - wheels[1])]) / 2
        left += (clipped_force < corner[0] - 1e-9).any() or (clipped_force > corner[1] + 1e-9).any()

    assert left > 0


def test_monitor_never_blames_a_disturbance_within_bounds() -> None:
    """The least push that explains a sample is at most the push that there was."""
    y, old, force = (ca.SX.sym(name) for name in ("y", "old", "force"))
    least = ca.Function("least", [y, old, force, SYMBOLS], [least_push(y, old, force, BOUNDS)])
    draw = np.random.default_rng(4)
    told = 0
    for _ in range(4000):
        row, u1 = drawn(draw)
        n = dict(zip(NAMES, row, strict=True))
        v, mass = draw.uniform(-u1, u1), draw.uniform(n["M_min"], n["M_max"])
        push, held = draw.uniform(-1, 1) * n["dbar"], draw.normal() * n["dbar"]
        slope = (held + push) / mass
        after = v + n["period"] * slope * draw.uniform(0, 1) ** (slope * v > 0)
        measured = [item + n["nbar"] * draw.uniform(-1, 1) for item in (after, v)]
        if v * after <= 0 and n["nbar"] == 0:
            continue
        found = float(least(*measured, held, row))
        told += found > 0
        assert found <= max(n["dbar"], 0) * (1 + 1e-9) + 1e-9 * mass * u1 / n["period"]

    assert told > 20


def evaluated(item: System, u: object, x: object) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    f = item.function("guard", [item.update, item.y, item.d])
    return tuple(part.full().ravel() for part in f(u, x, item.p0))


@pytest.mark.parametrize(
    ("order", "delay"),
    [("linear-first", 0.01), ("linear-first", 0.0), ("rotation-first", 0.024)],
)
@pytest.mark.slow_but("linear-first-0.01")
def test_guard_by_itself_equals_its_numpy_twin(order: str, delay: float) -> None:
    changed = {"guard.enabled": True, "actuator.tau_max": 12.0, "guard.map": order}
    changed |= {"actuator.delay": delay}
    scenario = load_scenario("paper-simulation", {**changed, "sensor.velocity_noise": [0.02, 0.03]})
    item, twin = guard(settle(scenario, None)), VelocityGuard(scenario, 12.0)
    draw, x = np.random.default_rng(5), np.array(item.x0)
    for _ in range(500):
        asked, v = draw.normal(size=2) * (300, 60), draw.uniform(-1.2, 1.2, 2) * (1.0, 1.5)
        thrust, moment = twin.act(tuple(asked), tuple(v), tuple(x[:2]))
        x, found, watched = evaluated(item, [*asked, *v], x)
        share = moment / scenario.robot.l
        torque = tuple(0.5 * scenario.robot.r * np.array([thrust + share, thrust - share]))
        assert found == pytest.approx(torque, abs=1e-12)
        assert abs(found).max() <= 12.0 * (1 + 1e-15)
        assert watched[:4] == pytest.approx([*twin.seen["clip_active"], *twin.seen["d_least"]])
        assert watched[4] == 1.0


def test_numpy_twin_derives_the_same_numbers() -> None:
    scenario = load_scenario("paper-simulation", {"guard.enabled": True})
    named = {item.signal.name: item.value for item in guard(settle(scenario, None)).params}
    for i, axis in enumerate(axes_of(scenario)):
        for name in ("M_min", "M_max", "dbar", "nbar", "f_min", "f_speed"):
            assert getattr(axis, name) == pytest.approx(named[f"guard.{name}"][i])
