"""The velocity guard: what keeps the limit, what brings the robot back, and what cannot be better.

All parameters are symbols.  The statements are about one sample of one axis; that they hold for
every instant of a run is the comparison lemma (guard.lemma) with induction over the samples.
"""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.guard.guard import ceiling, clipped, floor
from wmr_ctrl.model.dynamics import plant, rk4_step, wheel_to_force
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.common import PRESET, scalars
from wmr_ctrl.proofs.claims.guard_axis import GuardAxis, both_ways
from wmr_ctrl.proofs.ledger import HAND
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Relation, Statement, above, at_least, equal, symbols
from wmr_ctrl.scenario import load_scenario

ALL = (
    "every u1, T, 0 < M_min <= M_max, dbar, nbar, alpha T <= 1, brake, f_min, f_speed that are "
    "feasible"
)
FEASIBLE = (
    "2 (dbar - f_min) <= M_min alpha (u1 - f_speed), 2 nbar <= u1, brake >= dbar - f_min, "
    "brake >= 0"
)


claim = Claims(by=Z3(effort=150))


@claim("guard.feasible", given=f"{ALL}: {FEASIBLE}")
def not_empty(mutation: Mutation) -> Statement:
    """lo(y) <= hi(y) for every y.

    There is a safe force at every measured velocity.
    """
    a = GuardAxis()
    given = a.feasible(mutation(1, 1.01))
    return Statement(
        a.symbols, (at_least(ceiling(a["y"], a.bounds), floor(a["y"], a.bounds)),), given
    )


@claim("guard.upper", given=f"{ALL}: {FEASIBLE}; |v| <= u1, |y - v| <= nbar, M_min <= M <= M_max")
def upper(mutation: Mutation, way: int = 1) -> Statement:
    """max(v, f_speed) + t max(F + dbar - f_min, 0)/M <= u1 for all t in [0, T].

    Whatever the law asks for, the robot does not pass its limit forwards within the sample.
    """
    a = GuardAxis()
    given = (*a.feasible(1, mutation(1, 1.01)), *a.measured, *a.inside, *a.during)
    return Statement(a.symbols, (at_least(a["u1"], a.farthest(way)),), given)


@claim("guard.lower", given=f"{ALL}: {FEASIBLE}; |v| <= u1, |y - v| <= nbar, M_min <= M <= M_max")
def lower(mutation: Mutation) -> Statement:
    """max(-v, f_speed) + t max(-F + dbar - f_min, 0)/M <= u1 for all t in [0, T].

    Nor backwards.
    """
    return upper(mutation, -1)


@claim("guard.too-fast", given=f"{ALL}, but alpha T <= 1.01")
def too_fast(mutation: Mutation) -> Statement:
    """the same with alpha T up to 1.01.

    False: alpha = 1/T is the fastest approach to the limit that a held force admits.
    """
    return upper(-mutation, 1)


@both_ways(claim, "guard.outside", given=f"{ALL}: {FEASIBLE}; |y - v| <= nbar")
def outside(mutation: Mutation, way: int = 1) -> Statement:
    """v > u1: F + dbar - f_min <= -min(FB - dbar + f_min, M_max (v - u1)/T) <= 0.

    Outside the limit no disturbance can make the robot faster.
    """
    a = GuardAxis()
    b, beyond = a.bounds, way * a["v"] - a["u1"]
    spare = ca.fmin(b.brake, b.cap) - a.net
    needed = ca.fmin(spare, mutation(1, 1.01) * b.M_max * beyond / b.period)
    left = way * a.force + a.net
    given = (*a.feasible(), *a.measured, above(beyond))
    return Statement(a.symbols, (at_least(-left), at_least(-left, needed)), given)


@both_ways(claim, "guard.return", given=f"{ALL}: {FEASIBLE}; |y - v| <= nbar, M_min <= M <= M_max")
def return_step(mutation: Mutation, way: int = 1) -> Statement:
    """v > u1: after a sample v <= max(u1, v - T (FB - dbar + f_min)/M).

    Hence back inside within ceil((v - u1) M/(T (FB - dbar + f_min))) samples, M_max for M at worst.
    """
    a = GuardAxis()
    b, mass = a.bounds, a["mass"]
    step = b.period * (ca.fmin(b.brake, b.cap) - a.net) / mass
    start = way * a["v"]
    end = start + b.period * (way * a.force + a.net) / mass
    goal = at_least(ca.fmax(a["u1"], start - mutation(1, 1.01) * step), end)
    given = (*a.feasible(), *a.measured, *a.during, above(start, a["u1"]))
    return Statement(a.symbols, (goal,), given)


@both_ways(claim, "guard.no-overshoot", given=f"{ALL}: {FEASIBLE}")
def no_overshoot(mutation: Mutation, way: int = 1) -> Statement:
    """f_speed + t max(-F + dbar - f_min, 0)/M <= u1, also from v > u1.

    Braking from outside never throws the robot through the other limit.
    """
    a = GuardAxis()
    b = a.bounds
    fallen = b.f_speed + a["t"] * ca.fmax(a.net - way * a.force, 0) / a["mass"]
    limit = mutation(a["u1"], 0.99 * a["u1"])
    given = (*a.feasible(), *a.during, above(way * a["v"], a["u1"]), *a.measured)
    return Statement(a.symbols, (at_least(limit, fallen),), given)


@claim("guard.maximal", given="nbar = f_min = f_speed = 0, alpha = 1/T")
def maximal(mutation: Mutation) -> Statement:
    """0 <= v <= u1 and F > hi(v): v + T (F + dbar)/M_min > u1.

    No guard that intervenes less is safe.
    """
    a = GuardAxis()
    b = a.bounds
    exact = (b.nbar, b.f_min, b.f_speed, 1 - b.alpha * b.period)
    given = (*a.feasible(), *(Relation(item, "=") for item in exact), at_least(a["v"]), *a.inside)
    more = a["asked"] - ceiling(a["v"], b)
    end = a["v"] + b.period * (a["asked"] + b.dbar) / mutation(b.M_min, b.M_max)
    return Statement(a.symbols, (above(end, a["u1"]),), (*given, above(more)))


@claim("guard.necessary", given="u1, T, M_min, dbar > 0")
def necessary(mutation: Mutation) -> Statement:
    """2 dbar T > M_min u1 and F + dbar <= 0: T (dbar - F)/M_min > u1.

    Beyond this bound no guard at all can keep the limit: friction of unknown size may stop the
    robot.
    """
    t = symbols("u1 period M_min dbar force")
    held = at_least(ca.SX(0), t["force"] + t["dbar"])
    tight = above(2 * t["dbar"] * t["period"], mutation(1, 0.99) * t["M_min"] * t["u1"])
    swung = t["period"] * (t["dbar"] - t["force"]) / t["M_min"]
    positive = tuple(above(t[name]) for name in ("u1", "period", "M_min", "dbar"))
    return Statement(t, (above(swung, t["u1"]),), (*positive, tight, held))


@both_ways(
    claim, "guard.graceful", given=f"{ALL}: {FEASIBLE}; (FB - dbar + f_min) M_min >= M_max D"
)
def graceful(mutation: Mutation, way: int = 1) -> Statement:
    """|d| <= dbar + D keeps |v| <= u1 + D T/M_min.

    A bound that is broken by D costs a known excess, no more.
    """
    a = GuardAxis()
    b, extra = a.bounds, ca.SX.sym("extra")
    limit = b.u1 + mutation(1, 0.99) * extra * b.period / b.M_min
    brakes = (ca.fmin(b.brake, b.cap) - a.net) * b.M_min - b.M_max * extra
    given = (
        *a.feasible(),
        *a.measured,
        *a.during,
        at_least(extra),
        at_least(brakes),
        at_least(limit, way * a["v"]),
    )
    return Statement(
        {**a.symbols, "extra": extra}, (at_least(limit, a.farthest(way, extra)),), given
    )


@claim("guard.anchor", given=f"{ALL}: {FEASIBLE}")
def anchor(mutation: Mutation) -> Statement:
    """|clip(0, lo, hi)| <= FB.

    The force of least effort is within the brake cap.
    """
    a = GuardAxis()
    b = a.bounds
    size = ca.fabs(clipped(ca.SX(0), a["y"], b))
    cap = mutation(1, 0.99) * ca.fmin(b.brake, b.cap)
    return Statement(a.symbols, (at_least(cap, size),), a.feasible())


@claim("guard.simulated", given="every mu >= 0, m, I, r, l, g, v_s, h > 0, all inputs")
def simulated(mutation: Mutation) -> Statement:
    """one Runge-Kutta step h of the plant ends at v1 <= max(v1 + h max(F, 0)/m, h (|F| + 2 mu m
    g)/m), F all that pushes; omega ends at omega + h N/I.

    The simulated robot does not outrun the comparison that the guard counts with, but for speeds
    that friction alone turns round within a step. This is over the real numbers: the step's own
    rounding, some units in the last place of v a step, is not counted, so the simulated v may pass
    u1 by so much.
    """
    robot = plant(load_scenario(PRESET))
    t = {**scalars((*robot.inputs, *robot.state, *robot.params)), **symbols("step", "step")}
    m, inertia, mu, r, half, g, v_s = (
        t[f"robot.{name}"] for name in ("m", "I", "mu", "r", "l", "g", "v_s")
    )
    tau = ca.vertcat(t["tau_right"] + t["noise_right"], t["tau_left"] + t["noise_left"])
    push = wheel_to_force(r, half, tau) + ca.vertcat(t["thrust"], t["moment"])
    after = rk4_step(robot, t["step"])[3:5]
    friction = mu * m * g
    driven = t["v1"] + t["step"] * ca.fmax(push[0], 0) / m
    slow = t["step"] * (ca.fabs(push[0]) + mutation(2, -1) * friction) / m
    goals = (
        at_least(ca.fmax(driven, slow), after[0]),
        equal(after[1], t["omega"] + t["step"] * push[1] / inertia),
    )
    positive = tuple(above(item) for item in (m, inertia, r, half, g, v_s, t["step"]))
    given = (*positive, at_least(mu))
    return Statement(t, goals, given, {"thrust in all": push[0], "moment in all": push[1]})


@claim(
    "guard.lemma",
    given="F1 v >= f_min |v| above f_speed, F1 v >= 0 below, |d| <= dbar, F held",
    by=HAND,
)
def guard_lemma() -> None:
    """v+ = max(v, f_speed) is absolutely continuous, and M dv+/dt <= F + dbar - f_min where v >
    f_speed, 0 elsewhere; so v+(t) <= v+(0) + t max(F + dbar - f_min, 0)/M_min.

    One inequality at the sample bounds the velocity at every instant up to the next.
    """
