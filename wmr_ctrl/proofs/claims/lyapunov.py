"""The barrier function in time: Eqs. (9), (21)-(30), on the functions and on the law's graph."""

from __future__ import annotations

from wmr_ctrl.proofs.case import at
from wmr_ctrl.proofs.claim import CORRECTED, OURS, PRINTED, Claim
from wmr_ctrl.proofs.claims import lyapunov_steps as steps
from wmr_ctrl.proofs.claims.common import CLOSED_FORM, NO_SERIES, OFF_EDGES
from wmr_ctrl.proofs.claims.pairs import law_cases, paired_cases
from wmr_ctrl.proofs.methods.spec import Refute, Ring
from wmr_ctrl.proofs.regions import AxisName, off_target_cases, open_cases, target_cases

ONE, TWO = AxisName("1"), AxisName("2")
OPEN35, PAIRS = Ring(open_cases()), Ring(paired_cases(ONE, TWO), spare=12)
TARGETS7 = Ring(target_cases(edges=False))
LAW = tuple(Ring(law_cases(open_cases(), axis), CLOSED_FORM) for axis in (0, 1))
NONZERO = off_target_cases()
NOMINAL = OFF_EDGES + "; model exact, no disturbance, |v| below the clip" + NO_SERIES
KINK = (at(v="4/5", c="1/2", u1=1, u2="4/5", cdot=5, rho=15, h="1/1000000"),)
R2_POINT = (at(v=0, c=2, u1=1, u2="4/5", cdot=1),)
CLAIMS = (
    Claim(
        "eq21",
        (21,),
        PRINTED,
        "V1i' = z z' + f' + g', term by term",
        "Where the change of the barrier function comes from.",
        OFF_EDGES,
        steps.sum_rule,
        OPEN35,
    ),
    Claim(
        "eq22",
        (22,),
        PRINTED,
        "f' = sgn(v) v'/(v_u1 - |v|) where |v| > v_u2, else 0",
        "The barrier term resists only near the limit.",
        OFF_EDGES,
        steps.barrier_rate,
        OPEN35,
    ),
    Claim(
        "eq23",
        (23,),
        PRINTED,
        "g' = -(v_c1 - v_c0)(v_c1' - v_c0') - [sgn(v_c1) v_c1'/(v_u1 - |v_c1|)]",
        "How the reference value moves with the target.",
        OFF_EDGES,
        steps.minimum_rate,
        TARGETS7,
    ),
    Claim(
        "eq24",
        (24,),
        PRINTED,
        "(v_c1 - v_c0) v_c1' + [sgn(v_c1) v_c1'/(v_u1 - |v_c1|)] = 0",
        "At the best velocity a small change of it costs nothing.",
        OFF_EDGES,
        steps.envelope,
        TARGETS7,
    ),
    Claim(
        "eq25.printed",
        (25,),
        PRINTED,
        "g' = -(v_c1 - v_c0) v_c0'",
        "The sign is wrong wherever the target "
        "velocity is not v_c0 itself, that is whenever the limit matters.",
        OFF_EDGES,
        lambda s: steps.g_rate(-s),
        Refute(R2_POINT),
    ),
    Claim(
        "eq25",
        (25,),
        CORRECTED,
        "g' = +(v_c1 - v_c0) v_c0'",
        "With this sign (26) follows, as the paper needs.",
        OFF_EDGES,
        steps.g_rate,
        TARGETS7,
    ),
    Claim(
        "eq26",
        (26,),
        PRINTED,
        "V1' = A' v' - (v - v_c1)' v_c0', both axes together (it follows from the "
        "corrected (25), not from the printed one)",
        "What the law can do about the barrier function, and what the moving target does to it.",
        OFF_EDGES,
        steps.both_axes,
        PAIRS,
    ),
    Claim(
        "eq27",
        (27,),
        PRINTED,
        "V1' = V11' + V12'",
        "The axes do not interfere.",
        OFF_EDGES,
        steps.split,
        PAIRS,
    ),
    Claim(
        "eq28",
        (28,),
        PRINTED,
        "V1i' = A_i v_i' - (v_i - v_c1i) v_c0i', all 35 regions of v and v_c0",
        "Each axis by itself.",
        OFF_EDGES,
        steps.per_axis,
        OPEN35,
    ),
    Claim(
        "eq09",
        (9,),
        PRINTED,
        "A (F - F1) = M1 (-rho V1i + (v - v_c1) v_c0') for the model-based law's own graph, "
        "linear axis",
        "The compiled law is the paper's, only evaluated without dividing by A.",
        NOMINAL,
        steps.command,
        LAW[0],
    ),
    Claim(
        "eq09.angular",
        (9,),
        PRINTED,
        "the same on the angular axis",
        "The compiled law is the paper's.",
        NOMINAL,
        lambda s: steps.command(s, 1),
        LAW[1],
    ),
    Claim(
        "eq29.printed",
        (29,),
        PRINTED,
        "V1i' = +rho V1i, as the paper's text reads",
        "Read literally the velocity error would grow. The missing minus may be a misprint of the "
        "text at hand.",
        OFF_EDGES + "; A != 0",
        lambda s: steps.literal_decay(-s),
        Ring(NONZERO),
    ),
    Claim(
        "eq29",
        (29,),
        CORRECTED,
        "V1i' = -rho V1i under (9), where A is not 0",
        "The distance to the target velocity, measured by the barrier function, shrinks at the "
        "chosen rate.",
        OFF_EDGES + "; A != 0",
        steps.literal_decay,
        Ring(NONZERO),
    ),
    Claim(
        "eq30.law",
        (29, 30),
        OURS,
        "V1i' = -rho_i V1i for the compiled model-based law, linear axis, A = 0 included",
        "The law that runs on the robot has the property of the theorem, not just the formula on "
        "paper.",
        NOMINAL,
        steps.decay,
        LAW[0],
    ),
    Claim(
        "eq30.law-angular",
        (29, 30),
        OURS,
        "the same on the angular axis",
        "As on the linear axis.",
        NOMINAL,
        lambda s: steps.decay(s, 1),
        LAW[1],
    ),
    Claim(
        "eq30.printed",
        (30,),
        PRINTED,
        "V1' = -rho V1 at every instant, |v| = v_u2 included",
        "Exactly where the barrier begins, the acceleration that the law computes makes the "
        "barrier function rise "
        "for an instant (here at 13 1/s instead of falling). It holds at almost every instant, "
        "which is enough "
        "for the steps.decay.",
        "|v| = v_u2; change of V1i over at most 1 microsecond compared with -rho V1i, tolerance 1",
        steps.quotient_at_kink,
        Refute(KINK),
    ),
    Claim(
        "eq30",
        (30,),
        CORRECTED,
        "V1(t) = V1(0) exp(-rho t): (30) at almost every t, V1 continuous",
        "The steps.decay of the theorem is right in spite of the corner.",
        "model exact, no disturbance, one rho for both axes (else the slower one bounds V1)",
        verdict="HAND",
        premises=("eq29", "lemma.almost-everywhere"),
    ),
)
