"""The velocity guard: what keeps the limit, what brings the robot back, and what cannot be better.

All parameters are symbols.  The statements are about one sample of one axis; that they hold for
every instant of a run is the comparison lemma (guard.lemma) with induction over the samples.
"""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.guard.guard import ceiling, clipped, floor
from wmr_ctrl.guard.monitor import least_push
from wmr_ctrl.model.dynamics import wheel_to_force
from wmr_ctrl.model.plant import plant, rk4_step
from wmr_ctrl.proofs.claim import OURS, Claim
from wmr_ctrl.proofs.claims.common import PRESET, scalars
from wmr_ctrl.proofs.claims.guard_axis import GuardAxis
from wmr_ctrl.proofs.finding import HAND
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Relation, Statement, above, at_least, equal, symbols
from wmr_ctrl.scenario import load_scenario

THEME = "guard"
ALL = (
    "every u1, T, 0 < M_min <= M_max, dbar, nbar, alpha T <= 1, brake, f_min, f_speed that are "
    "feasible"
)
FEASIBLE = (
    "2 (dbar - f_min) <= M_min alpha (u1 - f_speed), 2 nbar <= u1, brake >= dbar - f_min, "
    "brake >= 0"
)


def _not_empty(flip: float) -> Statement:
    a = GuardAxis()
    given = a.feasible(1 if flip > 0 else 1.01)
    return Statement(
        a.symbols, (at_least(ceiling(a["y"], a.bounds), floor(a["y"], a.bounds)),), given
    )


def _invariant(way: int, flip: float) -> Statement:
    a = GuardAxis()
    given = (*a.feasible(1, 1 if flip > 0 else 1.01), *a.measured, *a.inside, *a.during)
    return Statement(a.symbols, (at_least(a["u1"], a.farthest(way)),), given)


def _upper(flip: float) -> Statement:
    return _invariant(1, flip)


def _lower(flip: float) -> Statement:
    return _invariant(-1, flip)


def _too_fast(flip: float) -> Statement:
    """The same with alpha T up to 1.01: false."""
    return _invariant(1, -flip)


def _outside(flip: float) -> Statement:
    """v > u1: the push left over is negative, and at least what the return needs."""
    a = GuardAxis()
    b, beyond = a.bounds, a["v"] - a["u1"]
    spare = ca.fmin(b.brake, b.cap) - a.net
    needed = ca.fmin(spare, (1 if flip > 0 else 1.01) * b.M_max * beyond / b.period)
    left = a.force + a.net
    given = (*a.feasible(), *a.measured, above(beyond))
    return Statement(a.symbols, (at_least(-left), at_least(-left, needed)), given)


def _return_step(flip: float) -> Statement:
    """One sample from outside: v falls to u1, or by T (FB - net)/M with the true mass M."""
    a = GuardAxis()
    b, mass = a.bounds, a["mass"]
    step = b.period * (ca.fmin(b.brake, b.cap) - a.net) / mass
    end = a["v"] + b.period * (a.force + a.net) / mass
    goal = at_least(ca.fmax(a["u1"], a["v"] - (1 if flip > 0 else 1.01) * step), end)
    given = (*a.feasible(), *a.measured, *a.during, above(a["v"], a["u1"]))
    return Statement(a.symbols, (goal,), given)


def _no_overshoot(flip: float) -> Statement:
    """From above, even if friction stops the robot at once, -u1 is not passed in a sample."""
    a = GuardAxis()
    b = a.bounds
    fallen = b.f_speed + a["t"] * ca.fmax(a.net - a.force, 0) / a["mass"]
    limit = a["u1"] if flip > 0 else 0.99 * a["u1"]
    given = (*a.feasible(), *a.during, above(a["v"], a["u1"]), *a.measured)
    return Statement(a.symbols, (at_least(limit, fallen),), given)


def _maximal(flip: float) -> Statement:
    """nbar = f_min = f_speed = 0, alpha = 1/T: any larger force can leave the limit."""
    a = GuardAxis()
    b = a.bounds
    exact = (b.nbar, b.f_min, b.f_speed, 1 - b.alpha * b.period)
    given = (*a.feasible(), *(Relation(item, "=") for item in exact), at_least(a["v"]), *a.inside)
    more = a["asked"] - ceiling(a["v"], b)
    end = a["v"] + b.period * (a["asked"] + b.dbar) / (b.M_min if flip > 0 else b.M_max)
    return Statement(a.symbols, (above(end, a["u1"]),), (*given, above(more)))


def _necessary(flip: float) -> Statement:
    """2 dbar T > M_min u1: what holds u1 against +dbar can swing to -u1 after a stop."""
    t = symbols("u1 period M_min dbar force")
    held = at_least(ca.SX(0), t["force"] + t["dbar"])
    tight = above(2 * t["dbar"] * t["period"], (1 if flip > 0 else 0.99) * t["M_min"] * t["u1"])
    swung = t["period"] * (t["dbar"] - t["force"]) / t["M_min"]
    positive = tuple(above(t[name]) for name in ("u1", "period", "M_min", "dbar"))
    return Statement(t, (above(swung, t["u1"]),), (*positive, tight, held))


def _graceful(flip: float) -> Statement:
    """|d| <= dbar + D: |v| <= u1 + D T/M_min stays true."""
    a = GuardAxis()
    b, extra = a.bounds, ca.SX.sym("extra")
    limit = b.u1 + (1 if flip > 0 else 0.99) * extra * b.period / b.M_min
    brakes = (ca.fmin(b.brake, b.cap) - a.net) * b.M_min - b.M_max * extra
    given = (
        *a.feasible(),
        *a.measured,
        *a.during,
        at_least(extra),
        at_least(brakes),
        at_least(limit, a["v"]),
    )
    return Statement({**a.symbols, "extra": extra}, (at_least(limit, a.farthest(1, extra)),), given)


def _anchor(flip: float) -> Statement:
    """The safe point: a force of 0, guarded, is at most the brake cap."""
    a = GuardAxis()
    b = a.bounds
    size = ca.fabs(clipped(ca.SX(0), a["y"], b))
    cap = (1 if flip > 0 else 0.99) * ca.fmin(b.brake, b.cap)
    return Statement(a.symbols, (at_least(cap, size),), a.feasible())


def _not_blamed(flip: float) -> Statement:
    """A sample that ran ahead, either way: d_least is at most the disturbance that pushed it."""
    a = GuardAxis()
    b, t = a.bounds, symbols("old push drag e_new e_old way")
    way = ca.if_else(t["way"] > 0, 1, -1)
    mean = (a["asked"] + way * (t["push"] - flip * t["drag"])) / a["mass"]
    new = t["old"] + b.period * mean
    y, before = new + t["e_new"], t["old"] + t["e_old"]
    errors = [at_least(b.nbar, side * t[name]) for side in (1, -1) for name in ("e_new", "e_old")]
    ahead = (
        above(ca.fmin(way * y, way * before), b.nbar), at_least(t["drag"]), at_least(t["push"]),
    )  # fmt: skip
    least = least_push(y, before, a["asked"], b)
    given = (*a.feasible(), *a.during, *errors, *ahead)
    return Statement({**a.symbols, **t}, (at_least(t["push"], least),), given)


def _simulated(flip: float) -> Statement:
    """One Runge-Kutta step of the plant's graph, both axes."""
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
    slow = t["step"] * (ca.fabs(push[0]) + (2 if flip > 0 else -1) * friction) / m
    goals = (
        at_least(ca.fmax(driven, slow), after[0]),
        equal(after[1], t["omega"] + t["step"] * push[1] / inertia),
    )
    positive = tuple(above(item) for item in (m, inertia, r, half, g, v_s, t["step"]))
    given = (*positive, at_least(mu))
    return Statement(t, goals, given, {"thrust in all": push[0], "moment in all": push[1]})


HARD = Z3(effort=150)

CLAIMS = (
    Claim(
        "guard.feasible",
        (),
        OURS,
        "lo(y) <= hi(y) for every y",
        "There is a safe force at every measured velocity.",
        f"{ALL}: {FEASIBLE}",
        _not_empty,
        HARD,
        theme=THEME,
    ),
    Claim(
        "guard.upper",
        (),
        OURS,
        "max(v, f_speed) + t max(F + dbar - f_min, 0)/M <= u1 for all t in [0, T]",
        "Whatever the law asks for, the robot does not pass its limit forwards within the sample.",
        f"{ALL}: {FEASIBLE}; |v| <= u1, |y - v| <= nbar, M_min <= M <= M_max",
        _upper,
        HARD,
        theme=THEME,
    ),
    Claim(
        "guard.lower",
        (),
        OURS,
        "max(-v, f_speed) + t max(-F + dbar - f_min, 0)/M <= u1 for all t in [0, T]",
        "Nor backwards.",
        f"{ALL}: {FEASIBLE}; |v| <= u1, |y - v| <= nbar, M_min <= M <= M_max",
        _lower,
        HARD,
        theme=THEME,
    ),
    Claim(
        "guard.too-fast",
        (),
        OURS,
        "the same with alpha T up to 1.01",
        "False: alpha = 1/T is the fastest approach to the limit that a held force admits.",
        f"{ALL}, but alpha T <= 1.01",
        _too_fast,
        HARD,
        theme=THEME,
    ),
    Claim(
        "guard.outside",
        (),
        OURS,
        "v > u1: F + dbar - f_min <= -min(FB - dbar + f_min, M_max (v - u1)/T) <= 0",
        "Outside the limit no disturbance can make the robot faster.",
        f"{ALL}: {FEASIBLE}; |y - v| <= nbar",
        _outside,
        HARD,
        theme=THEME,
    ),
    Claim(
        "guard.return",
        (),
        OURS,
        "v > u1: after a sample v <= max(u1, v - T (FB - dbar + f_min)/M)",
        "Hence back inside within ceil((v - u1) M/(T (FB - dbar + f_min))) samples, M_max for M "
        "at worst.",
        f"{ALL}: {FEASIBLE}; |y - v| <= nbar, M_min <= M <= M_max",
        _return_step,
        HARD,
        theme=THEME,
    ),
    Claim(
        "guard.no-overshoot",
        (),
        OURS,
        "f_speed + t max(-F + dbar - f_min, 0)/M <= u1, also from v > u1",
        "Braking from outside never throws the robot through the other limit.",
        f"{ALL}: {FEASIBLE}",
        _no_overshoot,
        HARD,
        theme=THEME,
    ),
    Claim(
        "guard.maximal",
        (),
        OURS,
        "0 <= v <= u1 and F > hi(v): v + T (F + dbar)/M_min > u1",
        "No guard that intervenes less is safe.",
        "nbar = f_min = f_speed = 0, alpha = 1/T",
        _maximal,
        HARD,
        theme=THEME,
    ),
    Claim(
        "guard.necessary",
        (),
        OURS,
        "2 dbar T > M_min u1 and F + dbar <= 0: T (dbar - F)/M_min > u1",
        "Beyond this bound no guard at all can keep the limit: friction of unknown size may "
        "stop the robot.",
        "u1, T, M_min, dbar > 0",
        _necessary,
        HARD,
        theme=THEME,
    ),
    Claim(
        "guard.graceful",
        (),
        OURS,
        "|d| <= dbar + D keeps |v| <= u1 + D T/M_min",
        "A bound that is broken by D costs a known excess, no more.",
        f"{ALL}: {FEASIBLE}; (FB - dbar + f_min) M_min >= M_max D",
        _graceful,
        HARD,
        theme=THEME,
    ),
    Claim(
        "guard.anchor",
        (),
        OURS,
        "|clip(0, lo, hi)| <= FB",
        "The force of least effort is within the brake cap.",
        f"{ALL}: {FEASIBLE}",
        _anchor,
        HARD,
        theme=THEME,
    ),
    Claim(
        "guard.monitor",
        (),
        OURS,
        "d_least <= mean disturbance of the sample, driving forwards or backwards",
        "The monitor accuses the bounds only where they are wrong.",
        f"{ALL}: {FEASIBLE}; both measured velocities beyond nbar on the same side, friction "
        "against the motion",
        _not_blamed,
        HARD,
        theme=THEME,
    ),
    Claim(
        "guard.simulated",
        (),
        OURS,
        "one Runge-Kutta step h of the plant ends at v1 <= max(v1 + h max(F, 0)/m, h (|F| + 2 mu m "
        "g)/m), F all that pushes; omega ends at omega + h N/I",
        "The simulated robot does not outrun the comparison that the guard counts with, but for "
        "speeds that friction alone turns round within a step. This is over the real numbers: the "
        "step's own rounding, some units in the last place of v a step, is not counted, so the "
        "simulated v may pass u1 by so much.",
        "every mu >= 0, m, I, r, l, g, v_s, h > 0, all inputs",
        _simulated,
        HARD,
        theme=THEME,
    ),
    Claim(
        "guard.lemma",
        (),
        OURS,
        "v+ = max(v, f_speed) is absolutely continuous, and M dv+/dt <= F + dbar - f_min where "
        "v > f_speed, 0 elsewhere; so v+(t) <= v+(0) + t max(F + dbar - f_min, 0)/M_min",
        "One inequality at the sample bounds the velocity at every instant up to the next.",
        "F1 v >= f_min |v| above f_speed, F1 v >= 0 below, |d| <= dbar, F held",
        verdict=HAND,
        theme=THEME,
    ),
)
