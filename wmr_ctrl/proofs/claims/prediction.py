"""Prediction to the time when a command acts: its times add up, and friction only slows down."""

from __future__ import annotations

from functools import reduce

import casadi as ca

from wmr_ctrl.laws.prediction import acts_for, slowed
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Statement, above, at_least, equal, symbols

MOST = 5
claim = Claims(by=Z3())


@claim("prediction.times", given=f"0 <= delay <= {MOST} T; up to {MOST} commands")
def prediction_times(mutation: Mutation) -> Statement:
    """tau_1 + ... + tau_n = delay, 0 <= tau_j <= T, n = 5.

    Over its delay the law counts on each command under way for as long as it acts.
    """
    t = symbols("delay period")
    delay, period = t["delay"], t["period"]
    times = [acts_for(age, delay, period) for age in range(1, MOST + 1)]
    total = reduce(ca.SX.__add__, times)
    goals = [equal(total, mutation * delay)]
    for time in times:
        goals += [at_least(time), at_least(period, time)]
    return Statement(t, tuple(goals), (at_least(delay), at_least(MOST * period, delay)))


@claim("prediction.order", given=f"delay >= 0, T > 0; j = 1 to {MOST - 1}")
def oldest_first(mutation: Mutation) -> Statement:
    """tau_j = T wherever tau_(j+1) is not 0.

    Only the oldest command under way acts for less than a period.
    """
    t = symbols("delay period")
    delay, period = t["delay"], t["period"]
    goals = []
    for age in range(1, MOST):
        newer, older = (acts_for(item, delay, period) for item in (age, age + 1))
        goals.append(equal(older * (newer - mutation * period)))
    return Statement(t, tuple(goals), (at_least(delay), above(period)))


@claim("prediction.friction", given="F1(u) u >= 0")
def friction(mutation: Mutation) -> Statement:
    """v+ has the sign of u, |v+| <= |u|, and v+ = u - t F1(u)/M while that is smaller than u.

    In the prediction friction slows the robot down and never turns it round.
    """
    t = symbols("free taken")
    free, taken = t["free"], t["taken"]
    after = slowed(free, taken)
    goals = (
        at_least(after * free),
        at_least(mutation * ca.fabs(free), ca.fabs(after)),
        equal(ca.fmax(ca.fabs(free) - ca.fabs(taken), 0) * (after - free + taken)),
    )
    return Statement(t, goals, (at_least(taken * free),))
