"""Commands under way behind a delay: what one of them does, and that their sums add up."""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.guard.delay import under_way
from wmr_ctrl.proofs.claim import Mutation
from wmr_ctrl.proofs.claims.guard_late import LateAxis
from wmr_ctrl.proofs.statement import Statement, above, at_least, column, equal

FEASIBLE = (
    "2 net (1 + alpha delay) <= M_min alpha (u1 - f_speed), net = dbar - f_min, 2 nbar <= u1, "
    "brake >= net, alpha T <= 1; every other number free"
)
CAPS = "0 <= brakes, net <= brakes <= largest (guard.delay.caps)"


def _command(axis: int, mutation: Mutation) -> Statement:
    """One command of at most ``largest``: both sums together, and what it does to v, either way."""
    a = LateAxis(axis)
    b, time = a.bounds, a["periods"] * a["period"]
    most = mutation(1, 0.99) * time * (a.largest + a.net) / b.M_min
    goals = [at_least(most, a.one.ahead + a.one.back)]
    for way, coming in ((1, a.one.ahead), (-1, a.one.back)):
        start = ca.fmax(way * a["v"], b.f_speed)
        seen = ca.fmax(way * a["y"] + b.nbar, b.f_speed)
        reached = start + a["since"] * ca.fmax(way * a["sent"] + a.net, 0) / a["mass"]
        goals.append(at_least(seen + coming, reached))
    sent = (at_least(a.largest, a["sent"]), at_least(a.largest, -a["sent"]))
    during = (at_least(a["since"]), at_least(time, a["since"]), at_least(a["periods"]))
    given = (*a.sound(), *a.capped, *a.measured, *a.during, *sent, *during)
    return Statement(a.symbols, tuple(goals), given)


def _queue(mutation: Mutation) -> Statement:
    """under_way of n commands is under_way of the first n - 1 and of the last."""
    a = LateAxis()
    t = {**column("F", 5), **column("N", 5), **column("time", 5)}
    sent = [(ca.vertcat(t[f"F{j}"], t[f"N{j}"]), t[f"time{j}"]) for j in range(1, 6)]
    goals = []
    for axis in (0, 1):
        for n in range(1, 6):
            every, last = (under_way(part, axis, a.bounds) for part in (sent[:n], sent[n - 1 : n]))
            rest = under_way(sent[: n - 1], axis, a.bounds)
            goals.append(equal(every.ahead, rest.ahead + mutation * last.ahead))
            goals.append(equal(every.back, rest.back + last.back))
    return Statement({**a.symbols, **t}, tuple(goals), (above(a.bounds.M_min),))
