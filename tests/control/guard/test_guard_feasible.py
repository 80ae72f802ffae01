"""feasible = 1 is enough, to the last digit: the guard's own graph evaluated in rationals."""

from fractions import Fraction
from functools import cache

import casadi as ca
import pytest

from wmr_ctrl.control.controller import guard
from wmr_ctrl.control.guard.guard import MAPS
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.statement import Statement, at_least

point = pytest.importorskip("wmr_proofs.methods.point")

NONE = (Fraction(0), Fraction(0))
KEPT_BACK = 1 - Fraction(2) ** -44


@cache
def exported(kind):
    """Both torques and the flag of the exported guard; the goals are only evaluated."""
    stated = {"guard.enabled": True, "guard.map": kind}
    system = guard(settle(load_scenario("paper-simulation", stated), None))
    (flag,) = (o.expr for o in system.diagnostics if o.signal.name == "feasible")
    values = (*(o.expr for o in system.outputs), flag)
    ports = (*system.inputs, *system.state, *system.params)
    table = {name: item.sym[i] for item in ports for i, name in enumerate(item.signal.elements)}
    return Statement(table, tuple(at_least(ca.SX(value)) for value in values))


def told(kind, numbers):
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


def excess(kind, numbers, v, off=NONE):
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


def at_the_edge(braked):
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


def test_brakes_beyond_the_wheels_by_a_rounding_are_not_feasible():
    """The thrust falls short in every sample then: v passes the limit by 1e-14, again and again."""
    braked = (Fraction("0.499999999999972"), Fraction("0.500000000000064"))
    over, flag = excess("linear-first", at_the_edge(braked), (LIMIT, LIMIT), TURNING)

    assert over > Fraction("1e-14")
    assert not flag


def test_brakes_that_are_just_within_reach_keep_both_limits():
    for kind in MAPS:
        numbers = at_the_edge((Fraction(1, 2), Fraction(1, 2)))
        over, flag = excess(kind, numbers, (LIMIT, LIMIT), TURNING)
        assert flag
        assert over <= 0
