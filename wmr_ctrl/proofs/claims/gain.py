"""Ours: near the limit law (9) resists nothing, so its velocity error has no gain of a disturbance.

For every bound D > 0 of the disturbing force there is a velocity v* < v_u1 from which a constant D
drives the robot over its limit, v_c0 held and the model exact:

    v* = v_u1 - delta g^2,    1/g = 3 + 2 delta B + (rho M/D) (8 delta + B),
    delta = v_u1 - v_u2,      B = v_u1 + |v_c0|

because V1/A falls to 0 there like the square root of the distance to the limit, or faster.  The
altered claims have the gradient law v' = -(rho/2) A + d/M in place of (9): they are refuted.
"""

from __future__ import annotations

from functools import partial

from wmr_ctrl.barrier.smooth import SmoothAxis
from wmr_ctrl.barrier.stable import Axis
from wmr_ctrl.proofs.claim import OURS, Claim
from wmr_ctrl.proofs.claims import gain_steps as steps
from wmr_ctrl.proofs.claims.common import ALL_LIMITS, CLOSED_FORM, NO_SERIES
from wmr_ctrl.proofs.finding import HAND
from wmr_ctrl.proofs.methods.spec import Z3, Ring, Table
from wmr_ctrl.proofs.regions import SMOOTH_TARGETS, TARGET_EDGES, TARGETS, all_cases, smooth_cases

STAR = (
    "v* = v_u1 - delta g^2, 1/g = 3 + 2 delta B + (rho M/D) (8 delta + B), delta = v_u1 - v_u2, "
    "B = v_u1 + |v_c0|"
)
AHEAD = smooth_cases(sides=("out+",))

CLAIMS = (
    Claim(
        "gain.ceiling",
        (12, 16),
        OURS,
        "V1i <= (v - v_c0)^2/2 + f(v)",
        "The barrier function grows no faster than its logarithm.",
        ALL_LIMITS,
        steps.ceiling,
        Ring(all_cases(), log_lemma=True),
        premises=("lemma.log",),
    ),
    Claim(
        "gain.ceiling-smooth",
        (),
        OURS,
        "the same for the smooth barrier as compiled, and its A is the paper's less "
        "1/(v_u1 - v_u2), for v > v_u2",
        "Nor does the smooth one.",
        "every 0 < v_u2 < v < v_u1, any v_c0" + NO_SERIES,
        steps.ceiling_smooth,
        Ring(AHEAD, CLOSED_FORM, log_lemma=True),
        premises=("lemma.log",),
    ),
    Claim(
        "gain.fades",
        (9, 10, 15),
        OURS,
        "rho M ((v - v_c0)^2/2 + f(v)) <= (D/2) (A - 1/(v_u1 - v_u2)) and A > 1/(v_u1 - v_u2) for "
        "every v in [v*, v_u1)",
        "However small a disturbing force is, close enough to the limit the barrier's share of the "
        "law resists less than half of it.",
        f"every 0 < v_u2 < v_u1, rho, M, D > 0, any v_c0; {STAR}",
        steps.fades,
        Ring((steps.near_limit(1), steps.near_limit(-1)), log_lemma=True),
        premises=("gain.cover", "lemma.log"),
    ),
    Claim(
        "gain.closed",
        (15,),
        OURS,
        "on [v*, v_u1) the compiled barrier evaluates phi at Y > 1/2, in closed form",
        "No series stands for the logarithm there.",
        "every 0 < v_u2 < v_u1, any |v_c0| < 1e100",
        partial(steps.closed, Axis),
        Ring(tuple(map(steps.charted, TARGETS + TARGET_EDGES))),
        premises=("gain.cover",),
    ),
    Claim(
        "gain.closed-smooth",
        (),
        OURS,
        "the same for the smooth barrier",
        "Nor in the smooth one.",
        "every 0 < v_u2 < v_u1, any |v_c0| < 1e100",
        partial(steps.closed, SmoothAxis),
        Ring(tuple(map(steps.charted, SMOOTH_TARGETS))),
        premises=("gain.cover",),
    ),
    Claim(
        "gain.cover",
        (),
        OURS,
        "the chart of gain.fades and gain.closed runs through all of [v*, v_u1)",
        "Nothing was left out.",
        "every 0 < v_u2 < v_u1, k = rho M/D > 0, any v_c0",
        steps.covered,
        Z3(),
    ),
    Claim(
        "gain.none",
        (9,),
        OURS,
        "on the model-based law's graph v' >= D/(2 M) for every v in [v*, v_u1), both axes",
        "From v* on, law (9) lets a constant force D > 0 drive the robot outwards all the way, "
        "however small D is. The gradient law in its place does not (the altered claim).",
        f"v_c0 held, model exact, v below the clip; {STAR}; mirrored at -v_u1",
        partial(steps.outward, "paper"),
        Z3(),
        premises=("gain.fades", "gain.ceiling", "gain.closed", "forms.quotient"),
    ),
    Claim(
        "gain.none-smooth",
        (),
        OURS,
        'the same for barrier = "smooth"',
        "A continuous slope does not mend it.",
        f"v_c0 held, model exact, v below the clip; {STAR}; mirrored at -v_u1",
        partial(steps.outward, "smooth"),
        Z3(),
        premises=("gain.fades", "gain.ceiling-smooth", "gain.closed-smooth", "smooth.quotient"),
    ),
    Claim(
        "gain.levels",
        (9,),
        OURS,
        "v* of D/M = d_max lies beyond the velocity at which d_max is held back, for v_c0 = 0, 1, "
        "..., 20 on both axes, and v* of each sampled setting (sampled.*) beyond its level",
        "What the barrier withstands from below and what it gives way to from v* on do not "
        "contradict each other.",
        "paper limits and gains",
        steps.levels,
        Table(points=steps.held_back),
        premises=("authority.lower-linear", "authority.lower-angular"),
    ),
    Claim(
        "gain.meaning",
        (9,),
        OURS,
        "under law (9) the velocity error has no input-to-state stability on |v| < v_u1: for every "
        "D > 0 a constant force D carries v from v* to v_u1 within 2 M (v_u1 - v*)/D",
        "No bound of the disturbance, however small, keeps V1 bounded from every start inside the "
        "limits; the gradient law has such a bound (prox.gain).",
        "v_c0 held, model exact",
        verdict=HAND,
        premises=("gain.none", "gain.none-smooth", "lemma.comparison"),
    ),
)
