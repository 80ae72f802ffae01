"""Parts put together: desired motions, dead reckoning, prediction to when a command acts."""

from functools import reduce

import casadi as ca

from wmr_ctrl.barrier.lyapunov import target_rate
from wmr_ctrl.laws.prediction import acts_for, slowed
from wmr_ctrl.proofs.case import POSITIVE, Case
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.common import (
    OFF_EDGES,
    LawGraph,
    barrier_axis,
)  # fmt: skip
from wmr_ctrl.proofs.methods.spec import Z3, Ring
from wmr_ctrl.proofs.regions import target_cases
from wmr_ctrl.proofs.statement import Relation, Statement, above, at_least, equal, symbols
from wmr_ctrl.world.pose_sensor import corrected, reckoned
from wmr_ctrl.world.references import curves

HARD = Z3(effort=150)
DECLARED = dict.fromkeys(("ref_radius", "ref_rate", "ref_speed"), POSITIVE)
POSITIVE_RATES = Ring((Case("rates > 0", declared=DECLARED),))
DIRECTION = "; that theta_d is the path's direction at one instant is up to the double for pi"
MOTIONS = ({"kind": "circle", "more": DIRECTION}, {"kind": "line", "more": ""})
claim = Claims(by=HARD)


@claim("law.mass", (4,), given="any values", by=Ring())
def believed(mutation: Mutation) -> Statement:
    """the inertia that a law believes in is diag(model.m, model.I).

    This is the M of the entries about laws.
    """
    law = LawGraph("mb")
    mass, t = law.own(law.context.mass), law.symbols
    return Statement(t, (equal(mass[0], mutation * t["model.m"]), equal(mass[1], t["model.I"])))


@claim("eq18.rate", (18, 23), given=OFF_EDGES, by=Ring(target_cases(edges=False)))
def eq18_rate(mutation: Mutation) -> Statement:
    """v_c1' = (d v_c1/d v_c0) v_c0'.

    How fast the target of the velocity moves.
    """
    a, _, c, u1, u2 = barrier_axis()
    t = {**a.symbols, **symbols("cdot")}
    rate = target_rate(c, t["cdot"], u1, u2)
    return Statement(t, (equal(rate, mutation * ca.gradient(a.x, c) * t["cdot"]),))


@claim("reference.{kind}", given="rates and radius > 0{more}", by=POSITIVE_RATES, over=MOTIONS)
def motion(mutation: Mutation, kind: str) -> Statement:
    """{kind}: x_d'^2 + y_d'^2 = v1d^2, x_d' y_d'' - y_d' x_d'' = v1d^2 v2d, theta_d' = v2d, and the
    published rates are the derivatives of v1d and v2d.

    The desired motion is one that the robot could make.
    """
    names = {"circle": "t ref_radius ref_rate", "line": "t ref_speed ref_heading x0 y0"}[kind]
    t = symbols(names, names.removeprefix("t "))
    given = {**t, "ref_origin": ca.vertcat(t["x0"], t["y0"])} if kind == "line" else t
    y = {"circle": curves.circle, "line": curves.line}[kind](t["t"], given)
    first = ca.jacobian(y, t["t"])
    second = ca.jacobian(first, t["t"])
    turned = first[0] * second[1] - first[1] * second[0]
    goals: tuple[Relation, ...] = (
        equal(first[0] ** 2 + first[1] ** 2, mutation * y[3] ** 2 + (1 - mutation)),
        equal(turned, y[3] ** 2 * y[4]),
        equal(first[2], y[4]),
        equal(first[3], y[5]),
        equal(first[4], y[6]),
    )
    if kind == "line":
        ahead = (equal(first[0], -ca.sin(y[2]) * y[3]), equal(first[1], ca.cos(y[2]) * y[3]))
        goals = (*goals, *ahead, equal(y[3], t["ref_speed"]))
    return Statement(t, goals)


@claim("estimator.pose", given="any values", by=Ring())
def estimator_pose(mutation: Mutation) -> Statement:
    """estimate = gain measured + (1 - gain) (old estimate moved by the old velocity).

    Dead reckoning: a whole correction takes the sensor's pose, none keeps moving.
    """
    names = "x y theta v omega x_m y_m theta_m period gain"
    t = symbols(names, names)
    pose, old = (ca.vertcat(*(t[n] for n in part.split())) for part in ("x y theta", "v omega"))
    measured, period, gain = ca.vertcat(t["x_m"], t["y_m"], t["theta_m"]), t["period"], t["gain"]
    theta = pose[2] + period * old[1]
    moved = pose + period * ca.vertcat(-old[0] * ca.sin(theta), old[0] * ca.cos(theta), old[1])
    estimate = corrected(reckoned(pose, old, period), measured, gain)
    goals = tuple(
        equal(estimate[i], gain * mutation * measured[i] + (1 - gain) * moved[i]) for i in range(3)
    )
    return Statement(t, goals)


MOST = 5
prediction_claim = Claims(by=Z3())


@prediction_claim("prediction.times", given=f"0 <= delay <= {MOST} T; up to {MOST} commands")
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


@prediction_claim("prediction.order", given=f"delay >= 0, T > 0; j = 1 to {MOST - 1}")
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


@prediction_claim("prediction.friction", given="F1(u) u >= 0")
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
