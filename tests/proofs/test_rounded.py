"""Statements about computed numbers cover exactly what rounding may do."""

from fractions import Fraction

import casadi as ca
import numpy as np
import pytest

from wmr_ctrl.control.filter.channels import WAYS, scaled
from wmr_ctrl.control.setup import settle
from wmr_ctrl.results.ledger import OPEN, PROVED, REFUTED
from wmr_ctrl.world.scenario import load_scenario, preset_names
from wmr_proofs.claims.filter_rounding import RIM, Limited
from wmr_proofs.methods.spec import Z3
from wmr_proofs.statement import UNIT, Statement, above, at_least, equal, symbols


def verdict(expr, goal, table, given=()):
    """Verdict on a goal about ``hat``, which is computed from ``expr``."""
    statement = Statement(table, (goal,), given, computed={"hat": expr})
    return Z3(effort=20).decide(statement).verdict


def test_a_sum_is_off_by_its_unit_and_no_more():
    t = symbols("x y hat")
    off, size = ca.fabs(t["hat"] - (t["x"] + t["y"])), ca.fabs(t["x"] + t["y"])

    assert verdict(t["x"] + t["y"], at_least(UNIT * size, off), t) == PROVED
    assert verdict(t["x"] + t["y"], at_least(0.99 * UNIT * size, off), t) == REFUTED


@pytest.mark.parametrize("exact", ["-x", "fmin(x, y)", "fabs(x)", "0.5 * x", "-4 * x"])
def test_what_is_exact_stays_exact(exact):
    t = symbols("x y hat")
    expr = eval(exact, {"fmin": ca.fmin, "fabs": ca.fabs}, t)

    assert verdict(expr, equal(t["hat"], expr), t) == PROVED


def test_a_quotient_by_a_parameter_is_rounded_twice():
    """The compiled text multiplies by an inverse, so a quotient is rounded twice."""
    t = symbols("x p hat", "p")
    once = at_least(UNIT * ca.fabs(t["x"]), ca.fabs(t["hat"] * t["p"] - t["x"]))
    twice = at_least(2.01 * UNIT * ca.fabs(t["x"]), ca.fabs(t["hat"] * t["p"] - t["x"]))

    assert verdict(t["x"] / t["p"], once, t, (above(t["p"]),)) == REFUTED
    assert verdict(t["x"] / t["p"], twice, t, (above(t["p"]),)) == PROVED


def test_an_error_that_is_not_known_is_refused():
    t = symbols("x hat")
    with pytest.raises(ValueError, match="log"):
        verdict(ca.log(t["x"]), equal(t["hat"]), t)


@pytest.mark.parametrize("name", preset_names())
def test_presets_lie_in_the_range_of_the_promise(name):
    """l M_min1 u1_1/(M_min2 u1_2) within [1/22, 22], and the conditions with a margin."""
    scenario = load_scenario(name)
    guard = settle(scenario, None).guard
    u1, low = scenario.limits.v_u1, guard.M_min
    ratio = scenario.robot.l * low[0] * u1[0] / (low[1] * u1[1])

    assert 1 / 22 <= ratio <= 22
    assert guard.alpha * scenario.clock.control <= 1 + 2.0**-50


def test_what_is_not_defined_behind_a_rounding_is_left_open():
    t = symbols("x y hat")
    share = ca.fmin(ca.fmax(t["y"] / t["x"], -1), 1)

    assert verdict(share, at_least(1, t["hat"]), t) == OPEN
    assert verdict(share, at_least(1, t["hat"]), t, (above(t["x"]),)) == PROVED
    guarded = ca.if_else(t["x"] > 0, ca.fmin(ca.sqrt(t["x"]), 1), 0)
    assert verdict(guarded, at_least(1, t["hat"]), t) == PROVED


@pytest.mark.parametrize(
    "on, scale",
    [(on, scale) for on in ("body", "wheels", "both") for scale in ("curvature", "turn", "drive")],
)
def test_what_doubles_scale_is_as_near_to_its_limits_as_is_proved(on, scale):
    """Scaled commands in doubles exceed wheel limits by the proved rounding at most.

    The comparison is in rationals; some commands do exceed a limit.
    """
    a, rng, passed = Limited(on), np.random.default_rng(1), 0
    sent = ca.Function("sent", [*a.symbols.values()], [scaled(*a.asked, scale)])
    wheels = [not a.is_axis(channel) for channel in a.channels]
    for _ in range(300):
        low, high = (way * 2.0 ** rng.uniform(-9, 3, len(wheels)) for way in (-1, 1))
        arm, r = rng.uniform(0.05, 2), rng.standard_normal(2) * 2.0 ** rng.uniform(-4, 9, 2)
        ends = np.ravel([high, low], order="F")
        v, omega = (Fraction(float(x)) for x in sent(arm, *r, 0, 0, 0, *ends).full().ravel())
        largest = Fraction(float(np.abs([low, high])[:, wheels].max(initial=0.0)))
        rims = [v + way * Fraction(float(arm)) * omega for way in WAYS]
        speeds = {"body": [v, omega], "wheels": rims, "both": [v, omega, *rims]}[on]
        for speed, least, most, wheel in zip(speeds, low, high, wheels, strict=True):
            end = abs(Fraction(float(most if speed > 0 else least)))
            assert abs(speed) <= end + (Fraction(RIM) * largest if wheel else 0)
            passed += abs(speed) > end
    assert passed or on == "body"
