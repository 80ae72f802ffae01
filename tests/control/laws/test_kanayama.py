"""The plain peer: its kinematic law, its two limits, its observer, and how well it tracks."""

import math

import numpy as np
import pytest

from wmr_ctrl.control.controller import law_graph
from wmr_ctrl.control.laws import kanayama
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.scenario import load_scenario

LAW = kanayama.LAW.name
OWN = f"gains.{LAW}"


# One sample, against the formulas of the law's own page in plain numbers.

T, MASS, RATE, K, A_MAX = 0.05, (60.0, 4.0), (9.0, 6.0), (1.5, 2.0, 3.0), (2.0, 6.0)
PLAIN = {
    "clock.control": T, "model.m": MASS[0], "model.I": MASS[1], "model.mu": 0.1,
    f"{OWN}.k": list(K), f"{OWN}.rate": list(RATE), f"{OWN}.a_max": list(A_MAX), f"{OWN}.wo": 0.0,
}  # fmt: skip


def asked(rows):
    """Command and force (2,) for rows of inputs, last command, and the observer's force."""
    system = law_graph(settle(load_scenario("paper-simulation-nominal", PLAIN), LAW))
    graph = system.function("sample", [system.update, system.y])
    found = []
    for row in rows:
        u, last, made_up = row[:12], row[12:14], row[14:]
        state = np.concatenate((last, made_up, u[10:], [1.0]))
        update, force = graph(np.concatenate((u, [0.0, 0.0])), state, system.p0)
        found.append((update.full().ravel()[:2], force.full().ravel()))
    return found


def by_hand(row):
    x_d, y_d, theta_d, v1_d, v2_d, *rates, x, y, theta = (float(item) for item in row[:10])
    v, last, made_up = row[10:12], row[12:14], row[14:]
    way = math.sin(theta), math.cos(theta)
    e1 = -way[0] * (x_d - x) + way[1] * (y_d - y)
    e2 = -way[1] * (x_d - x) - way[0] * (y_d - y)
    turned = theta_d - theta
    wanted = np.array((
        v1_d * math.cos(turned) + K[0] * e1,
        v2_d + v1_d * (K[1] * e2 + K[2] * math.sin(turned)),
    ))  # fmt: skip
    top, step = 0.95 * np.array((1.0, 1.5)), T * np.array(A_MAX)
    command = last + np.clip(np.clip(wanted, -top, top) - last, -step, step)
    a = np.array(rates) + (1 - np.exp(-T * np.array(RATE))) / T * (command - v)
    drag = 0.1 * MASS[0] * 9.81 * math.tanh((v[0] + T * a[0]) / 0.01)
    return command, np.array(MASS) * a + (drag, 0.0) + made_up


def drawn(count):
    """Rows near the reference, turned by up to a half turn, slow enough for friction to bend."""
    draw = np.random.default_rng(5)
    size = [*(0.1, 0.1, 3.0, 0.3, 0.3, 0.3, 0.3), *(0.1, 0.1, 0.1, 0.03, 0.3), *(0.1, 0.4, 5, 1)]
    return list(draw.uniform(-1, 1, (count, 16)) * size)


def test_command_and_force_are_those_of_its_formulas():
    rows = drawn(60)
    found = asked(rows)

    for row, (command, force) in zip(rows, found, strict=True):
        told = by_hand(row)
        assert command == pytest.approx(told[0], rel=1e-12, abs=1e-14)
        assert force == pytest.approx(told[1], rel=1e-10, abs=1e-10)
    cut = np.isclose([abs(c - r[12:14]) for r, (c, _) in zip(rows, found, strict=True)],
                     T * np.array(A_MAX))  # fmt: skip
    assert (cut.any(axis=0) & ~cut.all(axis=0)).all()
