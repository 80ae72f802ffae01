"""Sentences of docs/explanation/guarantee.md, each tried on a plant of its own.

Nothing here integrates with the product's code; of the product there is the guard's graph alone.
"""

import casadi as ca
import numpy as np
import pytest

from wmr_ctrl.control.controller import guard
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.model.evaluate import evaluated
from wmr_ctrl.world.scenario import load_scenario

U1, R, L = np.array((1.0, 1.5)), 0.1, 0.25
LOW, HIGH, DBAR = np.array((45.0, 4.86)), np.array((71.5, 7.7)), np.array((60.0, 15.0))
TICKS, ROBOTS = 20, 150
CLOSE = 1e-9


def scenario_at(period, delay=0.0, **further):
    return load_scenario("safe-simulation", {
        "clock.control": period, "clock.plant": period / TICKS, "clock.duration": 600 * period,
        "changes": [], "actuator.delay": delay, "guard.M_min": LOW.tolist(),
        "guard.M_max": HIGH.tolist(), "guard.dbar": DBAR.tolist(),
    } | further)  # fmt: skip


class Guards:
    """Many guards side by side: asked forces and velocities (2, N) to forces (2, N)."""

    def __init__(self, scenario, count=ROBOTS):
        system = guard(settle(scenario, None))
        self.names = [name for item in system.diagnostics for name in item.signal.elements]
        act = system.function("act", [*map(ca.densify, (system.update, system.y, system.d))])
        self._act, self._p = act.map(count), np.tile(np.reshape(system.p0, (-1, 1)), count)
        self.state = np.tile(np.reshape(system.x0, (-1, 1)), count)

    def __call__(self, asked, v):
        given = np.vstack((asked, v))
        self.state, torque, told = evaluated(self._act, given.T, self.state.T, self._p.T)
        self.told = dict(zip(self.names, told, strict=True))
        return np.vstack((torque.sum(0), L * (torque[0] - torque[1]))) / R


def tick(v, force, push, drag, mass, h):
    """v (2, N) after ``h`` [s]; Coulomb friction stops, holds, and never drives.  Exact."""
    net = force + push
    sign = np.where(v != 0, np.sign(v), np.sign(net))
    rate = (net - sign * drag) / mass
    held = (v == 0) & (np.abs(net) <= drag)
    after = np.where(held, 0.0, v + h * rate)
    stops = (v != 0) & (after * v < 0)
    left = np.where(stops, h - np.abs(v / np.where(stops, rate, 1.0)), 0.0)
    away = (net - np.sign(net) * drag) / mass
    onward = np.where(np.abs(net) > drag, left * away, 0.0)
    return np.where(stops, onward, after)


class World:
    """Robots whose mass, friction and push an adversary chooses anew at every sample."""

    def __init__(self, seed, v, period, delay=0.0, excess=0.0):
        self.draw, self.v, self.h = np.random.default_rng(seed), v, period / TICKS
        self.late, self.excess, self.commands = round(delay / self.h), excess, []
        self.fastest = np.abs(v)

    def sample(self, force):
        """One period; the command acts ``late`` ticks after it was given."""
        shape, draw = self.v.shape, self.draw
        self.commands.append(force)
        mass = np.where(draw.random(shape) < 0.7, LOW[:, None], HIGH[:, None])
        drag = np.where(draw.random(shape) < 0.5, 0.0, 400 * draw.random(shape))
        outward = np.where(self.v >= 0, 1.0, -1.0)
        kind = draw.random(shape)
        push = np.where(kind < 0.6, outward, np.where(kind < 0.8, -outward, 2 * kind - 1))
        push = push * (DBAR[:, None] + self.excess)
        for k in range(TICKS):
            due = ((len(self.commands) - 1) * TICKS + k - self.late) // TICKS
            acting = self.commands[due] if due >= 0 else np.zeros(shape)
            self.v = tick(self.v, acting, push, drag, mass, self.h)
            self.fastest = np.maximum(self.fastest, np.abs(self.v))


def asked(draw, count):
    """What a law may ask: anything."""
    size = 10.0 ** draw.uniform(0, 5, (2, count)) * draw.choice([-1.0, 1.0], (2, count))
    return np.where(draw.random((2, count)) < 0.1, 0.0, size)


def guarded(world, draw, period, delay):
    """The world after 120 samples; there is always a safe force."""
    guards = Guards(scenario_at(period, delay))
    for _ in range(120):
        world.sample(guards(asked(draw, ROBOTS), world.v))
        assert guards.told["feasible"].all()


CLOCKS = [(0.01, 0.0), (0.1, 0.0), (0.01, 0.025), (0.1, 0.03)]
clocks = pytest.mark.parametrize("period, delay", CLOCKS)


@clocks
@pytest.mark.slow_but("0.01-0.025")
def test_inside_stays_inside_and_there_is_always_a_safe_force(period, delay):
    """1 and 3: at every instant, for every law."""
    draw = np.random.default_rng(1)
    start = U1 - delay * DBAR / LOW  # "inside" with a delay
    world = World(2, draw.uniform(-1, 1, (2, ROBOTS)) * start[:, None], period, delay)
    guarded(world, draw, period, delay)
    assert (world.fastest <= U1[:, None] * (1 + CLOSE)).all()
    assert (world.fastest.max(axis=1) > 0.99 * U1).all()


@pytest.mark.parametrize("period", [0.01, 0.1])
def test_outside_comes_back_in_time_and_not_through_the_other_side(period):
    """2: the speed never grows, and the limit is reached within the stated samples."""
    scenario, draw = scenario_at(period), np.random.default_rng(3)
    guards, brake = Guards(scenario), np.array(settle(scenario, None).value("guard.brake"))
    v = draw.uniform(1, 3, (2, ROBOTS)) * U1[:, None] * draw.choice([-1.0, 1.0], (2, ROBOTS))
    world, before = World(4, v, period), np.abs(v)
    over = np.abs(v) - U1[:, None]
    most = np.ceil(over * HIGH[:, None] / (period * (brake - DBAR)[:, None]))
    for k in range(int(most.max()) + 1):
        assert (np.abs(world.v) <= U1[:, None] * (1 + CLOSE))[most <= k].all()
        world.sample(guards(asked(draw, ROBOTS), world.v))
        speed = np.abs(world.v)
        assert (speed <= np.maximum(before, U1[:, None]) * (1 + CLOSE)).all()
        before = speed
    assert (before <= U1[:, None] * (1 + CLOSE)).all()


@pytest.mark.parametrize("period", [0.01, 0.1])
def test_a_refused_force_could_leave_the_limit(period):
    """4: for some admissible mass, push and friction, with alpha = 1/T and exact measurement.

    Friction may stop at once a robot that moves the other way, and then vanish.
    """
    guards, draw = Guards(scenario_at(period)), np.random.default_rng(5)
    v = draw.uniform(-1, 1, (2, ROBOTS)) * U1[:, None]
    wanted = asked(draw, ROBOTS)
    forces = guards(wanted, v)
    cut = (np.abs(wanted - forces) > 1e-6 * np.abs(wanted)) & (np.abs(wanted) > np.abs(forces))
    out = np.sign(wanted)
    for factor, leaves in ((1 + 1e-6, True), (1 - 1e-6, False)):
        tried = forces + out * (factor - 1) * np.maximum(np.abs(forces), DBAR[:, None])
        speeds = []
        for mass in (LOW, HIGH):
            after = out * np.maximum(out * v, 0.0)
            for _ in range(TICKS):
                after = tick(after, tried, out * DBAR[:, None], 0.0, mass[:, None], period / TICKS)
            speeds.append(np.abs(after))
        beyond = np.maximum(*speeds) > U1[:, None] * (1 + 1e-12)
        assert beyond[cut].all() if leaves else not beyond[cut].any()
    assert cut.sum() > ROBOTS / 2


@clocks
@pytest.mark.slow_but("0.01-0.025")
def test_a_broken_bound_costs_what_it_says(period, delay):
    """5: |d| <= dbar + D keeps the speed below v_u1 + D (T + delay)/M_min."""
    excess = 0.1 * DBAR[:, None]
    world = World(7, np.zeros((2, ROBOTS)), period, delay, excess)
    guarded(world, np.random.default_rng(6), period, delay)
    most = U1[:, None] + excess * (period + delay) / LOW[:, None]
    assert (world.fastest <= most * (1 + CLOSE)).all()
    assert (world.fastest.max(axis=1) > U1).any()


def test_what_cannot_hold_is_refused_with_the_number():
    """The inequalities of the page, just met and just missed."""
    edge = 45 * 1.0 / (2 * 60.0)  # 2 dbar <= M_min u1/T, thrust
    turn = 4.86 * 1.5 / (2 * 15.0)
    assert turn < edge
    settle(scenario_at(round(0.99 * turn, 4)), None)
    for broken in (
        {"period": round(1.01 * turn, 4)},
        {"period": 0.01, "guard.nbar": [0.51, 0.0]},
        {"period": 0.01, "guard.alpha": 100.1},
        {"period": 0.01, "actuator.tau_max": 0.99 * (60 + 15 / L) * R / 2},
    ):
        with pytest.raises(ScenarioError, match="guard"):
            settle(scenario_at(**broken), None)


def test_the_page_has_no_guarantee_that_is_not_tried_here():
    """Five items, and each is the subject of a test above."""
    import re
    from pathlib import Path

    page = (Path(__file__).parents[3] / "docs/explanation/guarantee.md").read_text("utf-8")
    items = re.findall(r"^(\d)\. \*\*(.+?)\.\*\*", page.split("## How it works")[0], re.MULTILINE)
    own = Path(__file__).read_text(encoding="utf-8")

    assert [number for number, _ in items] == ["1", "2", "3", "4", "5"]
    assert all(re.search(rf'"""(\d and )?{number}( and \d)?: ', own) for number, _ in items)
