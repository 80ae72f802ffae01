"""Prediction to the time when a command acts: its times add up, and friction only slows down."""

from __future__ import annotations

from functools import reduce

import casadi as ca

from wmr_ctrl.laws.prediction import acts_for, slowed
from wmr_ctrl.proofs.claim import OURS, Claim
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Statement, above, at_least, equal, symbols

MOST = 5


def _times(flip: float) -> Statement:
    """tau_1 + ... + tau_n = delay for delay <= n T, each of them from 0 to T, n = 1 to MOST."""
    t = symbols("delay period")
    delay, period = t["delay"], t["period"]
    times = [acts_for(age, delay, period) for age in range(1, MOST + 1)]
    total = reduce(ca.SX.__add__, times)
    goals = [equal(total, flip * delay)]
    for time in times:
        goals += [at_least(time), at_least(period, time)]
    return Statement(t, tuple(goals), (at_least(delay), at_least(MOST * period, delay)))


def _oldest_first(flip: float) -> Statement:
    """A command acts for all of T unless it is the oldest that acts at all."""
    t = symbols("delay period")
    delay, period = t["delay"], t["period"]
    goals = []
    for age in range(1, MOST):
        newer, older = (acts_for(item, delay, period) for item in (age, age + 1))
        goals.append(equal(older * (newer - flip * period)))
    return Statement(t, tuple(goals), (at_least(delay), above(period)))


def _friction(flip: float) -> Statement:
    """0 <= v+/free <= 1 where friction is against the motion, and v+ = free - taken if it lasts."""
    t = symbols("free taken")
    free, taken = t["free"], t["taken"]
    after = slowed(free, taken)
    goals = (
        at_least(after * free),
        at_least(flip * ca.fabs(free), ca.fabs(after)),
        equal(ca.fmax(ca.fabs(free) - ca.fabs(taken), 0) * (after - free + taken)),
    )
    return Statement(t, goals, (at_least(taken * free),))


CLAIMS = (
    Claim(
        "prediction.times",
        (),
        OURS,
        f"tau_1 + ... + tau_n = delay, 0 <= tau_j <= T, n = {MOST}",
        "Over its delay the law counts on each command under way for as long as it acts.",
        f"0 <= delay <= {MOST} T; up to {MOST} commands",
        _times,
        Z3(),
    ),
    Claim(
        "prediction.order",
        (),
        OURS,
        "tau_j = T wherever tau_(j+1) is not 0",
        "Only the oldest command under way acts for less than a period.",
        f"delay >= 0, T > 0; j = 1 to {MOST - 1}",
        _oldest_first,
        Z3(),
    ),
    Claim(
        "prediction.friction",
        (),
        OURS,
        "v+ has the sign of u, |v+| <= |u|, and v+ = u - t F1(u)/M while that is smaller than u",
        "In the prediction friction slows the robot down and never turns it round.",
        "F1(u) u >= 0",
        _friction,
        Z3(),
    ),
)
