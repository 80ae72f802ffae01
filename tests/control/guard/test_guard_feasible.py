"""feasible = 1 is enough, to the last digit: the guard's own graph evaluated in rationals."""

from __future__ import annotations

from fractions import Fraction
from functools import cache

import casadi as ca
import numpy as np
import pytest

from wmr_ctrl.control.controller import guard
from wmr_ctrl.control.guard.guard import MAPS
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.relation import at_least
from wmr_proofs.statement import Statement

point = pytest.importorskip("wmr_proofs.methods.point")

Pair = tuple[Fraction, Fraction]
NONE = (Fraction(0), Fraction(0))
KEPT_BACK = 1 - Fraction(2) ** -44


@cache
def exported(kind: str) -> Statement:
    """Both torques and the flag of the exported guard; the goals are only evaluated."""
    stated = {"guard.enabled": True, "guard.map": kind}
    system = guard(settle(load_scenario("paper-simulation", stated), None))
    (flag,) = (o.expr for o in system.diagnostics if o.signal.name == "feasible")
    values = (*(o.expr for o in system.outputs), flag)
    ports = (*system.inputs, *system.state, *system.params)
    table = {name: item.sym[i] for item in ports for i, name in enumerate(item.signal.elements)}
    return Statement(table, tuple(at_least(ca.SX(value)) for value in values))


def told(kind: str, numbers: dict[str, object]) -> tuple[Fraction, Fraction, bool]:
    """Exact thrust and moment of the torques, and the flag; r = l = 1, so that phi = 2 tau_max."""
    at = {name: Fraction(0) for name in exported(kind).symbols}
    at |= {"robot.r": Fraction(1), "robot.l": Fraction(1)}
    for name, value in numbers.items():
        pairs = (
            [(f"{name}[{i + 1}]", part) for i, part in enumerate(value)]
            if (isinstance(value, tuple))
            else [(name, value)]
        )
        at |= {key: Fraction(part) for key, part in pairs}
    right, left, flag = point.evaluate(exported(kind), at)
    return right + left, right - left, flag == 1


def excess(
    kind: str, numbers: dict[str, object], v: Pair, off: Pair = NONE
) -> tuple[Fraction, bool]:
    """By how much the worst motion of a sample passes the limit that is aimed at, and the flag.

    The velocities v are measured ``off`` by so much, and ever more force is asked for.
    """
    asked = tuple(Fraction(10) ** 6 * (1 if speed > 0 else -1) for speed in v)
    seen = {"v1": v[0] + off[0], "omega": v[1] + off[1]}
    *force, flag = told(kind, {**numbers, **seen, "force": asked})
    T, found = numbers["clock.control"], []
    for i, speed in enumerate(v):
        way = 1 if speed > 0 else -1
        f_speed, low = numbers["guard.f_speed"][i], numbers["guard.M_min"][i]
        push = way * force[i] + numbers["guard.dbar"][i] - numbers["guard.f_min"][i]
        end = max(way * speed, f_speed) + T * max(push, Fraction(0)) / low
        found.append(end - numbers["limits.v_u1"][i] * KEPT_BACK)
    return max(found), flag


def at_the_edge(braked: Pair) -> dict[str, object]:
    """Two light axes that are pushed as hard as their wheels can hold, T = 1/2."""
    rows = {"M_min": "1", "M_max": "1", "dbar": "2", "f_min": "1.500000000000043", "f_speed": "0"}
    return {
        **{f"guard.{name}": (Fraction(row), Fraction(row)) for name, row in rows.items()},
        "guard.nbar": (Fraction(0), Fraction(1, 2)), "guard.brake": braked,
        "guard.alpha": Fraction(1), "clock.control": Fraction(1, 2),
        "actuator.tau_max": Fraction(1, 2), "limits.v_u1": (Fraction(2), Fraction(2)),
    }  # fmt: skip


LIMIT = 2 * KEPT_BACK
TURNING = (Fraction(0), Fraction(1, 2))
"""The turn is measured too fast, so that it is braked as hard as may be."""


def test_brakes_beyond_the_wheels_by_a_rounding_are_not_feasible() -> None:
    """The thrust falls short in every sample then: v passes the limit by 1e-14, again and again."""
    braked = (Fraction("0.499999999999972"), Fraction("0.500000000000064"))
    over, flag = excess("linear-first", at_the_edge(braked), (LIMIT, LIMIT), TURNING)

    assert over > Fraction("1e-14")
    assert not flag


def test_brakes_that_are_just_within_reach_keep_both_limits() -> None:
    for kind in MAPS:
        numbers = at_the_edge((Fraction(1, 2), Fraction(1, 2)))
        over, flag = excess(kind, numbers, (LIMIT, LIMIT), TURNING)
        assert flag
        assert over <= 0


@pytest.mark.slow
def test_near_the_edge_of_what_is_feasible_the_limit_is_kept_exactly() -> None:
    """Every condition is met or missed by a few 2^-46: where the flag is 1, nothing passes."""
    draw, said, closest = np.random.default_rng(5), {True: 0, False: 0}, Fraction(-1)
    for _ in range(400):
        near = [1 + Fraction(int(k), 2**46) for k in draw.integers(-2, 3, 5)]
        T, limits = (
            Fraction(int(draw.integers(1, 9)), 8),
            (Fraction(1), Fraction(int(draw.integers(1, 5)), 2)),
        )
        net = [Fraction(int(draw.integers(1, 9)), 8) * u * KEPT_BACK / 2 / T for u in limits]
        net[0] *= near[0]
        phi = (2 * sum(net)) * near[1]
        brake = (net[0] * near[2], phi - net[0])
        numbers = {
            "guard.M_min": (Fraction(1), Fraction(1)), "guard.M_max": (Fraction(1), Fraction(2)),
            "guard.dbar": tuple(net), "guard.f_min": NONE, "guard.f_speed": NONE,
            "guard.nbar": (limits[0] * KEPT_BACK / 2 * near[3], Fraction(0)), "guard.brake": brake,
            "guard.alpha": near[4] / T, "clock.control": T, "actuator.tau_max": phi / 2,
            "limits.v_u1": limits,
        }  # fmt: skip
        way, kind = draw.choice([-1, 1], 2), list(MAPS)[int(draw.integers(2))]
        v = tuple(int(s) * u * KEPT_BACK for s, u in zip(way, limits, strict=True))
        over, flag = excess(kind, numbers, v)
        said[flag] += 1
        if flag:
            assert over <= 0, (kind, numbers)
            closest = max(closest, over)

    assert min(said.values()) > 40
    assert closest == 0
