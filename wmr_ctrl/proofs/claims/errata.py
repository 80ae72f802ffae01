"""What does not hold as the paper says it, beyond single equations: each with an exact point."""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.barrier import lyapunov as analysis
from wmr_ctrl.barrier import theorem1
from wmr_ctrl.model.auxiliary import auxiliary_velocity
from wmr_ctrl.model.tracking import error_rate
from wmr_ctrl.proofs.case import at
from wmr_ctrl.proofs.claim import CORRECTED, OURS, PRINTED, Claim
from wmr_ctrl.proofs.claims.common import BarrierAxis
from wmr_ctrl.proofs.claims.tracking import Tracking
from wmr_ctrl.proofs.methods.spec import Z3, Refute
from wmr_ctrl.proofs.statement import Statement, above, at_least, column, equal, stacked, symbols


def _only_rest(_: float) -> Statement:
    """With v = v_c0 the error moves wherever it is not 0."""
    t = Tracking()
    rate = error_rate(t.e, auxiliary_velocity(t.e, t.v_d, t.k), t.v_d)
    return Statement(t.names, (above(ca.sumsqr(rate)),), (above(ca.sumsqr(t.e)), above(t.v_d[0])))


def _ball(_: float) -> Statement:
    """V2 <= r^2/2 implies |e| <= r."""
    t = Tracking()
    names = {**t.names, **symbols("r")}
    given = (
        at_least(0.5 * names["r"] ** 2, analysis.position_lyapunov(t.e, t.k[1])),
        above(names["r"]),
    )
    return Statement(names, (at_least(names["r"] ** 2, ca.sumsqr(t.e)),), given)


def _omega(_: float) -> Statement:
    """V2 at any e in the ball Omega_1 is at most its value at (0, 0, radius), on the edge."""
    t = Tracking()
    names = {**t.names, **symbols("eps0 l")}
    radius = theorem1.ball_radius(names["eps0"], names["l"], t.k)
    given = (at_least(radius**2, ca.sumsqr(t.e)), above(names["l"], 5), above(names["eps0"]))
    other = ca.vertcat(0, 0, radius)
    return Statement(
        names,
        (
            at_least(
                analysis.position_lyapunov(other, t.k[1]), analysis.position_lyapunov(t.e, t.k[1])
            ),
        ),
        given,
    )


def _stays_on_target(_: float) -> Statement:
    """On target (v = v_c0, |v| < v_u2) the command is v_c0', as staying there needs."""
    a = BarrierAxis()
    v, c, u1, u2 = a.all
    t = {**a.symbols, **symbols("rho cdot")}
    command = analysis.printed_command(t["rho"], v, c, t["cdot"], u1, u2)
    return Statement(
        t,
        (equal(command, t["cdot"]),),
        (*a.inside, equal(v, c), above(u2, ca.fabs(v)), above(t["rho"])),
    )


def _one_rate(_: float) -> Statement:
    """V1' = -rho V1 with one rho, where the gains are rho_1 and rho_2 as in Section V."""
    t = {**column("V", 2), **column("rho", 2), **symbols("rho")}
    total = t["V1"] + t["V2"]
    rate = -t["rho1"] * t["V1"] - t["rho2"] * t["V2"]
    paper = (
        equal(t["rho1"], 15),
        equal(5 * t["rho2"], 288),
        at_least(t["V1"]),
        at_least(t["V2"]),
        equal(t["rho"], t["rho1"]),
    )
    return Statement(t, (equal(rate, -t["rho"] * total),), paper)


def _slower_rate(flip: float) -> Statement:
    t = {**column("V", 2), **column("rho", 2)}
    least = ca.fmin(t["rho1"], t["rho2"]) if flip > 0 else ca.fmax(t["rho1"], t["rho2"])
    rate = -t["rho1"] * t["V1"] - t["rho2"] * t["V2"]
    given = tuple(at_least(t[name]) for name in t)
    return Statement(t, (at_least(-least * (t["V1"] + t["V2"]), rate),), given)


def _forgetting_binds(flip: float) -> Statement:
    """rho2 <= 0.08 1/s whatever rho1 is."""
    t = {**column("rho", 2), **column("M", 2)}
    sigma, gamma = ca.SX([1, 1]), ca.SX([2, 0.08])
    rate = analysis.decay_rate(stacked(t, "rho", 2), stacked(t, "M", 2), sigma, gamma)
    given = (above(t["M1"]), above(t["M2"]))
    return Statement(t, (at_least(0.081 if flip > 0 else 0.07, rate),), given)


PAPER: dict[str, str | int] = {"v1d": "1/5", "v2d": "1/10", "k1": 10, "k2": 5, "k3": 4}
BACKWARDS = ({**at(e1=0, e2=0, **PAPER), "e3": "1 pi"},)
TURNED = (at(e1=0, e2=0, e3="11/10", k2=5, r="1/2"),)
EDGE = ({**at(e1=1, e2=0, e3=0, l=257, eps0="1/2", k1=10, k2=5, k3=4)},)
ON_TARGET = (at(v="3/10", c="3/10", u1=1, u2="4/5", rho=15, cdot=1),)

CLAIMS = (
    Claim(
        "thm1.global",
        (7, 39),
        PRINTED,
        "(Theorem 1) e converges to 0 from everywhere: e = 0 is the only rest of the "
        "error under v = v_c0",
        "A robot exactly on the path but facing backwards, e = (0, 0, pi), stays like that for "
        "ever: it backs along the path, and no term of the law turns it. Convergence is almost "
        "global at best.",
        "v1d > 0",
        _only_rest,
        Refute(BACKWARDS),
    ),
    Claim(
        "eq61.ball",
        (39, 61),
        PRINTED,
        "small V2 is the same as a small ball: V2 <= r^2/2 implies |e| <= r, as the "
        "definition of Omega_1 and Omega_3 by a radius needs",
        "V2 counts the angle less than the distance (by 1/k2), so "
        "a set where V2 stops growing is no ball: with r = 0.5 the angle may still be 1.1 rad.",
        "r > 0, k2 = 5",
        _ball,
        Refute(TURNED),
    ),
    Claim(
        "eq61.omega",
        (61,),
        PRINTED,
        "inside the ball Omega_1 V2 is at most what it is on the ball's edge, so that no "
        "motion which lowers V2 leaves the ball",
        "An error can leave the ball while V2 falls: the stated sets are not "
        "shown to hold the robot.",
        "radius of Omega_1, l > 5",
        _omega,
        Refute(EDGE),
    ),
    Claim(
        "eq09.pseudo-inverse",
        (9,),
        PRINTED,
        "A^-1 := 0 where A = 0 keeps a robot on its target velocity: the command there is v_c0'",
        "On target the printed law commands acceleration 0 instead of the target's. A robot that "
        "starts with v = v_c0 falls behind at once; the code takes the limit v_c0' instead.",
        "v = v_c0, |v| < v_u2",
        _stays_on_target,
        Refute(ON_TARGET),
    ),
    Claim(
        "eq30.vector",
        (30,),
        PRINTED,
        "V1' = -rho V1 with the two gains of Section V",
        "With one gain per axis the sum does not decay at one rate.",
        "rho_1 = 15, rho_2 = 57.6, rho = rho_1",
        _one_rate,
        Refute((at(V1=0, V2=1, rho1=15, rho2="288/5", rho=15),)),
    ),
    Claim(
        "eq30.slower",
        (30,),
        CORRECTED,
        "V1' <= -min(rho_1, rho_2) V1",
        "The slower axis sets the pace.",
        "V1i >= 0, rho_i >= 0, V1i' = -rho_i V1i",
        _slower_rate,
        Z3(),
        premises=("eq30.law", "eq30.law-angular"),
    ),
    Claim(
        "eq86.forgetting",
        (86,),
        OURS,
        "with sigma Gamma = (2, 0.08) 1/s rho2 stays below 0.081 1/s whatever rho1 is "
        "(the text says that rho1 raises it)",
        "The time constant of the paper's guarantee is 12.5 s and no gain of the "
        "velocity loop shortens it.",
        "M1ii > 0",
        _forgetting_binds,
        Z3(),
    ),
)
