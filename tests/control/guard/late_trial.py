"""The product's guard before exact robots that are as adverse as their bounds allow."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import casadi as ca
import numpy as np

from tests.control.guard.exact_axis import PARTS, Robots
from tests.control.guard.late_formula import LateGuard
from tests.tables import changes
from wmr_ctrl.control.controller import guard as guard_system
from wmr_ctrl.control.guard.refusals import feasible_guard
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.effect import Bound
from wmr_ctrl.world.model.evaluate import evaluated
from wmr_ctrl.world.scenario import load_scenario

LIMITS = np.array([1.0, 1.5])
BY_SIGN, BY_TIME = 0, 1


@dataclass(frozen=True)
class Case:
    """Numbers stated for a guarded robot. Forces are for the first axis; the second has a fifth.

    Times are in s, except ``lo``, ``hi``, ``age``, ``window`` and ``lag`` in control periods. If
    ``fast`` is given, the time constant varies between ``fast`` and ``lag``.
    """

    T: float = 0.1
    age: float = 0.0
    window: float = 0.0
    lo: float = 0.0
    hi: float = 0.0
    lag: float = 0.0
    fast: float | None = None
    dbar: float = 30.0
    nbar: float = 0.0
    f_min: float = 0.0
    f_speed: float = 0.0
    brake: float | None = None
    alpha: float = 1.0
    M_min: float = 45.0
    tau_max: float | None = None

    def formula(self, axis):
        """This case's numbers for the formula in NumPy; the limit is shrunk as in the product."""
        setup, share = settled(self), (1.0, 0.2)[axis]
        stated = setup.guard
        count = max(item.roundings for item in stated.lateness(setup.scenario.clock))
        return LateGuard(
            T=self.T, u1=LIMITS[axis] * (1 - 2.0**-44 * (1 + count)), M_min=share * self.M_min,
            M_max=share * 70.0, net=share * (self.dbar - self.f_min), nbar=self.nbar,
            f_speed=self.f_speed, brake=stated.brake[axis], alpha=self.alpha / self.T,
            age=self.age * self.T, window=self.window * self.T, lo=self.lo * self.T,
            hi=self.hi * self.T, lag=self.lag * self.T,
            fast=None if self.fast is None else self.fast * self.T,
        )  # fmt: skip


@lru_cache(maxsize=512)
def settled(case):
    """Settle a guard without a law, with the numbers of a case."""
    changed = changes(f"""
        guard.enabled = true
        guard.trust = true
        clock.duration = 80.0
        clock.control = {case.T}
        clock.plant = {case.T / PARTS}
        disturbance.std = 0.0
        guard.M_min = [{case.M_min}, {0.2 * case.M_min}]
        guard.M_max = [70.0, 14.0]
        guard.dbar = [{case.dbar}, {0.2 * case.dbar}]
        guard.nbar = [{case.nbar}, {case.nbar}]
        guard.f_min = [{case.f_min}, {0.2 * case.f_min}]
        guard.f_speed = [{case.f_speed}, {case.f_speed}]
        guard.alpha = {case.alpha / case.T}
    """)
    if case.brake is not None:
        changed["guard.brake"] = [case.brake, 0.2 * case.brake]
    if case.tau_max is not None:
        changed["actuator.tau_max"] = case.tau_max
    scenario = load_scenario("paper-simulation-nominal", changed)
    lag, old, wide = (x * case.T for x in (case.lag, case.age, case.window))
    fast = lag if case.fast is None else case.fast * case.T
    bound = Bound(
        delay=case.hi * case.T, jitter=(case.hi - case.lo) * case.T, lag=(fast, lag),
        age=(old, old), window=(wide, wide),
    )  # fmt: skip
    stated = feasible_guard(scenario, bound, np.inf)
    return replace(settle(scenario, None), guard=stated)


@lru_cache(maxsize=512)
def composed(case):
    """Return the guard of a case and its function: next state, torques and diagnostics."""
    system = guard_system(settled(case))
    return system, system.function("guard", [*map(ca.densify, (system.update, system.y, system.d))])


@dataclass(frozen=True)
class Result:
    """Largest |v|/limit per axis, d_least/dbar, and the difference of product and formula [N].

    ``seen``: velocities (parts, 2, lanes), each at the end of its part; ``mass`` (2, lanes).
    """

    fastest: np.ndarray
    blamed: float
    apart: float
    seen: np.ndarray
    mass: np.ndarray


@dataclass(frozen=True)
class Thrown:
    """The event that brings robots outside: a start at ``start`` v_u1, or a push of ``times`` dbar.

    The push lasts ``samples``.  Both act in the direction ``way`` (lanes) of +-1.
    """

    way: np.ndarray
    start: float = 0.0
    times: float = 0.0
    samples: int = 0


def trial(
    case,
    lanes,
    samples,
    seed,
    true=None,
    compare=True,
    thrown=None,
):
    """Robots with the numbers of ``true`` (or those stated) behind the guard of a case."""
    draw, real = np.random.default_rng(seed), true or case
    thrown = thrown or Thrown(np.ones(lanes))
    system, one = composed(case)
    act = one.map(lanes)
    p = np.tile(np.array(system.p0)[:, None], lanes)
    x = np.tile(np.array(system.x0)[:, None], lanes)
    formulas = [case.formula(axis) for axis in (0, 1)]
    n = max(formulas[0].n, 1) + 1
    sent = [np.zeros((2, lanes))] * n
    tails = [[np.full(lanes, item.first_tail)] * 2 for item in formulas]
    share = np.array([[1.0], [0.2]]) * np.ones((2, lanes))
    h, robot = case.T / PARTS, settled(case).scenario.robot
    ways = {name: _ways(draw, lanes, samples) for name in ("asked", "push", "error")}
    chosen = draw.random((samples, PARTS, 2, lanes))
    mean_late = draw.choice([0.0, 0.5, 1.0], lanes)
    lags = _time_constants(draw, lanes, real)
    mass = share * np.where(draw.random(lanes) < 0.2, 70.0, real.M_min)
    grip = draw.choice([0.0, 0.0, 0.1, 0.5], lanes)
    begin = np.outer(thrown.start * LIMITS, thrown.way)
    robots = Robots(begin.ravel(), np.zeros(2 * lanes), lags(np.zeros(2 * lanes)))
    old, wide = (round(t * PARTS) for t in (real.age, real.window))
    way_of_part = [np.zeros((2, lanes))] * (old + wide + 1)
    speeds = [begin] * (old + wide + 1)
    acting, coming = np.zeros((2, lanes)), []
    seen, blamed, apart = [], 0.0, 0.0
    for k in range(samples):
        v = robots.v.reshape(2, lanes)
        y = sum(way_of_part[old : old + wide]) / (wide * h) if wide else speeds[old]
        y = y + real.nbar * ways["error"](k, 0, -v)
        asked = 1e6 * ways["asked"](k, 0, v) * (draw.random(lanes) < 0.95)
        following, torque, watched = evaluated(act, np.vstack([asked, y]).T, x.T, p.T)
        x = following
        force = np.array(
            [torque[0] + torque[1], robot.l * (torque[0] - torque[1])]
        ) / robot.r  # fmt: skip
        if compare:
            free = np.abs(torque).max(axis=0) < 0.999 * (case.tau_max or np.inf)
            apart = max(apart, _difference(formulas, tails, sent, y, asked, force, free))
        blamed = max(blamed, float((watched[2:4] / (share * case.dbar)).max()))
        sent = [force, *sent[:-1]]
        later = np.where(draw.random(lanes) < mean_late, real.hi, real.lo)
        coming = [*coming[-6:], (k * PARTS + np.round(later * PARTS), force)]
        for i in range(PARTS):
            for start, new in coming:
                acting = np.where(start == k * PARTS + i, new, acting)
            v = robots.v.reshape(2, lanes)
            push = share * real.dbar * ways["push"](k, i, v)
            if k < thrown.samples:
                push = share * real.dbar * thrown.times * thrown.way
            held = np.where(chosen[k, i] < grip, np.inf, 0.0)
            robots.lag = lags((acting.ravel() - robots.acting) * np.where(v < 0, -1.0, 1.0).ravel())
            most = np.abs(push) + np.maximum(np.abs(acting), np.abs(robots.acting.reshape(v.shape)))
            sure = share * real.f_min * (np.abs(v) + h * most / mass > real.f_speed)
            total = robots.move(
                acting.ravel(), push.ravel(), mass.ravel(), np.maximum(held, sure).ravel(), h
            )
            way_of_part = [total.reshape(2, lanes), *way_of_part[:-1]]
            speeds = [robots.v.reshape(2, lanes), *speeds[:-1]]
            seen.append(speeds[0])
    fastest = np.abs(seen).max(axis=(0, 2)) / LIMITS
    return Result(fastest, blamed, apart, np.array(seen), mass)


def _time_constants(draw, lanes, real):
    """Return a function of the missing outward force: time constants [s] of both axes."""
    one = real.lag * draw.choice([0.0, 0.3, 1.0, 1.0], lanes)
    if real.fast is None:
        return lambda _: np.tile(real.T * one, 2)
    both = np.array([real.fast, real.lag])
    by_chance = np.tile(draw.random(lanes) < 0.3, 2)

    def chosen(outward):
        worst = np.where(outward > 0, both[0], both[1])
        mixed = draw.choice([*both, both.mean()], 2 * lanes)
        return real.T * np.where(by_chance, mixed, worst)

    return chosen


def _ways(draw, lanes, samples):
    """+-1 per sample, part and lane: the velocity's sign, a rhythm, or random."""
    kind = draw.integers(0, 3, lanes)
    half = np.exp(draw.uniform(0, np.log(6 * PARTS), (2, lanes)))
    phase, duty = draw.uniform(0, 2, (2, lanes)) * half, draw.uniform(0.1, 0.9, (2, lanes))
    chance = np.where(draw.random((samples, PARTS, 2, lanes)) < duty, 1.0, -1.0)

    def way(k, i, v):
        rhythm = np.where((k * PARTS + i + phase) % (2 * half) < 2 * half * duty, 1.0, -1.0)
        other = np.where(kind == BY_TIME, rhythm, chance[k, i])
        return np.where(kind == BY_SIGN, np.where(v < 0, -1.0, 1.0), other)

    return way


def _difference(formulas, tails, sent, y, asked, force, free):
    """Largest difference of the product's force from the formula's on lanes with ``free`` wheels.

    Updates ``tails``.
    """
    apart = 0.0
    for axis, item in enumerate(formulas):
        own = [each[axis] for each in sent]
        hi = item.hi_of(y[axis], own, tails[axis][0], 1.0)
        lo = -item.hi_of(y[axis], own, tails[axis][1], -1.0)
        assert (lo <= hi + 1e-9 * item.M_min * item.u1 / item.T).all()
        apart = max(apart, (free * np.abs(np.clip(asked[axis], lo, hi) - force[axis])).max())
        commands = [force[axis], *own]
        tails[axis] = [
            item.next_tail(tail, commands, way)
            for tail, way in zip(tails[axis], (1.0, -1.0), strict=True)
        ]
    return apart
