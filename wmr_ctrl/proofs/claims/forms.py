"""What C evaluates equals the paper's functions; what the series leaves out."""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.laws import stable_barrier as stable
from wmr_ctrl.proofs.case import NONNEGATIVE, POSITIVE, Case
from wmr_ctrl.proofs.claim import OURS, Claim
from wmr_ctrl.proofs.claims.common import ALL_LIMITS, CLOSED_FORM, NO_SERIES, BarrierAxis
from wmr_ctrl.proofs.methods.spec import Both, Ring, Z3
from wmr_ctrl.proofs.regions import all_cases, target_cases
from wmr_ctrl.proofs.statement import Statement, above, at_least, equal, symbols


def _target(flip: float) -> Statement:
    a = BarrierAxis()
    _, c, u1, u2 = a.all
    only = stable.stable_minimiser(c, u1, u2)
    return Statement(a.symbols, (equal(only, flip * a.x),))


def _distance(flip: float) -> Statement:
    a = BarrierAxis()
    return Statement(a.symbols, (equal(a.stable.w, a.all[0] - flip * a.x), equal(a.stable.v_c1, a.x)))


def _value(flip: float) -> Statement:
    a = BarrierAxis()
    return Statement(a.symbols, (equal(a.stable.V1, flip * a.V),))


def _quotient(flip: float) -> Statement:
    a = BarrierAxis()
    return Statement(a.symbols, (equal(a.stable.V1_over_A * a.A, flip * a.V),))


def _q(flip: float) -> Statement:
    a = BarrierAxis()
    return Statement(a.symbols, (equal(a.stable.q * a.A, flip * a.w),))


def _series_slope(flip: float) -> Statement:
    """R = phi(y) - y chi(y) with chi the compiled series: |R'| <= 2^-52 |y| for |y| < 0.05."""
    t = symbols("y")
    y = t["y"]
    chi = stable._chi(y, 1 - y)
    slope = (1 / (1 - y) - 1) - ca.gradient(y * chi, y)
    bound = (2.0**-52 if flip > 0 else 2.0**-56) * ca.fabs(y)
    return Statement(t, (at_least(bound, slope), at_least(bound, -slope)))


def _closed_slope(flip: float) -> Statement:
    """The closed form: d/dy (y chi(y)) = phi'(y) exactly."""
    t = symbols("y")
    y = t["y"]
    return Statement(t, (equal(ca.gradient(y * stable._chi(y, 1 - y), y), 1 / (1 - y) - flip),))


def _small(sign: int) -> Case:
    """0 <= |y| < 0.05: y = n/(20 n + m)."""
    def values(n: dict[str, object]) -> dict[str, object]:
        return {"y": sign * n["n"] / (20 * n["n"] + n["m"])}  # type: ignore[operator]

    return Case(f"y {'+' if sign > 0 else '-'}", {"n": POSITIVE, "m": POSITIVE}, values)  # type: ignore[arg-type]


def _large() -> tuple[Case, ...]:
    """0.05 < y < 1 and y < -0.05."""
    return (
        Case("0.05 < y < 1", {"n": POSITIVE}, lambda n: {"y": (n["n"] + 1) / (n["n"] + 19)}),
        Case("y < -0.05", {"n": POSITIVE}, lambda n: {"y": -n["n"] - 1}),
    )
