"""The adaptive network: Eqs. (57)-(73), (82)-(88), all 64 nodes of one axis on the law's graph."""

from __future__ import annotations

from dataclasses import replace

from wmr_ctrl.laws import nn
from wmr_ctrl.proofs.case import FREE, NONNEGATIVE, NONZERO, POSITIVE, Case, at
from wmr_ctrl.proofs.claim import CORRECTED, OURS, PRINTED, Claim
from wmr_ctrl.proofs.claims import network_steps as steps
from wmr_ctrl.proofs.methods.spec import Z3, Refute, Ring
from wmr_ctrl.proofs.regions import AxisName

NODES, DIMENSIONS = nn.NODES, 6
GAINS = {f"gains.nn.{name}[1]": POSITIVE for name in ("rho1", "Gamma", "sigma")} | {
    "clock.control": POSITIVE
}
VECTORS = {f"{name}{j}": FREE for j in range(1, NODES + 1) for name in ("S", "X", "E")}
SOLVED = {
    "A": NONZERO,
    "mass": POSITIVE,
    "cdot": FREE,
    "y": NONZERO,
    "n": FREE,
    "p": NONNEGATIVE,
    **VECTORS,
}
FREE_CASES = (
    Case(
        "A != 0",
        {"A": NONZERO, "V": FREE, "w": FREE},
        steps.free_chart,
        {"mass": POSITIVE, **GAINS},
    ),
)
OFF_CASES = (replace(FREE_CASES[0], numbers={"A": NONZERO, "V": FREE, "w": NONZERO}),)
BOTH_CASES = (
    *FREE_CASES,
    Case(
        "A = 0",
        dict.fromkeys(("quotient", "q"), FREE),
        steps.vanishing_chart,
        {"mass": POSITIVE, **GAINS},
    ),
)
BOUND_CASES = (Case("A != 0", SOLVED, steps.residual_chart, GAINS),)
RATES = dict.fromkeys(("rho2", "gamma"), POSITIVE) | dict.fromkeys(("a", "b"), NONNEGATIVE)
DECAY_CASES = (
    Case(
        "rho2 below both rates", {**SOLVED, **RATES}, steps.decay_chart, {"clock.control": POSITIVE}
    ),
)
ALL_NODES = "all 64 weights, any S(Z), any A, V1, w with A != 0 or A = V1 = w = 0, W* constant"
OFF_TARGET = "all 64 weights, any S(Z); A and v - v_c1 not 0 (there (59) cannot be written down)"
ONE = Ring(FREE_CASES, spare=0)
OFF = Ring(OFF_CASES, spare=0)
TWO = Ring(BOTH_CASES, spare=0)
BOUND = Ring(BOUND_CASES, spare=0)
FAR_POINT = (at(v="7999999/10000000", c=3, u1=1, u2="4/5"),)
CLAIMS = (
    Claim(
        "eq57",
        (57,),
        PRINTED,
        "F = -rho1 V1/A + q W^'S(Z) on the compiled law's graph, 64 nodes",
        "The network law that runs is the paper's, with the quotients by their cancellation-free "
        "forms.",
        "any weights and basis",
        steps.law,
        ONE,
    ),
    Claim(
        "eq58",
        (58,),
        PRINTED,
        "W^' = -Gamma (S(Z) (v - v_c1) + sigma W^), linear axis, all 64 weights: the "
        "compiled Euler step integrates it",
        "The weights learn from the distance to the target velocity and slowly forget.",
        "any weights and basis",
        steps.adaptation,
        ONE,
    ),
    Claim(
        "eq58.angular",
        (58,),
        PRINTED,
        "the same on the angular axis",
        "As on the linear axis.",
        "any weights and basis",
        lambda s: steps.adaptation(s, 1),
        ONE,
    ),
    Claim(
        "eq58.basis",
        (57, 58),
        OURS,
        "the compiled basis (one exponential per dimension more than one) equals "
        "exp(-|Z - c_j|^2/eta^2) at all 64 nodes",
        "The fast evaluation of the network changes nothing.",
        "any Z and eta; nodes at -1 and 1",
        steps.basis_product,
        Ring((Case("any Z", declared={"eta": POSITIVE}),), spare=14),
    ),
    Claim(
        "eq59.printed",
        (59,),
        PRINTED,
        "the target (59) is bounded on a bounded set of velocities, so that a "
        "network can approximate it",
        "Just below v_u2 with v_c0 = 3 m/s the network would have to give more than "
        "a million times the friction force: no bounded weights do that. Theorem 2 assumes it, so "
        "its bound is "
        "empty in the middle region.",
        "|v| <= 0.95 v_u1, |v_c0| <= 3; ratio <= 10^6 for instance",
        steps.target_bounded,
        Refute(FAR_POINT),
    ),
    Claim(
        "eq59.ratio",
        (59,),
        OURS,
        "A/(v - v_c1) = 1 + (v_c0 - v_u2)/(v_u2 - v) for 0 <= v < v_u2, v_u2 < v_c0 <= v_u2 + "
        "1/(v_u1 - v_u2): it grows without bound as v rises to v_u2",
        "The regressor of the network blows up in normal operation, which is why the code caps it.",
        "every 0 < v_u2 < v_u1",
        steps.ratio,
        Ring(tuple(AxisName().case("middle+", side) for side in ("zero", "in+"))),
    ),
    Claim(
        "eq63-66",
        (62, 63, 64, 65, 66),
        PRINTED,
        "differentiating V3i = V1i + W~'W~/(2 M1 Gamma) gives (66)",
        "How velocity error and learning error change together.",
        ALL_NODES,
        steps.differentiated,
        TWO,
    ),
    Claim(
        "eq67-68",
        (67, 68),
        PRINTED,
        "with (28), (4) and constant W*",
        "Force and friction enter.",
        ALL_NODES,
        steps.substituted,
        TWO,
    ),
    Claim(
        "eq69",
        (69,),
        PRINTED,
        "with the law (57)",
        "The feedback appears as a decay.",
        ALL_NODES,
        steps.with_law,
        TWO,
    ),
    Claim(
        "eq70",
        (70,),
        PRINTED,
        "with (59) as the definition of eps2",
        "What the network cannot represent remains as eps2.",
        OFF_TARGET,
        steps.with_target,
        OFF,
    ),
    Claim(
        "eq71",
        (71,),
        PRINTED,
        "with the adaptation (58)",
        "Learning cancels the unknown part; only the forgetting term and eps2 remain.",
        OFF_TARGET,
        steps.with_adaptation,
        OFF,
    ),
    Claim(
        "eq72",
        (72,),
        PRINTED,
        "V3i' <= (71) with w eps2 <= w^2/2 + eps2^2/2; what is left over is (w - eps2)^2/(2 M1)",
        "The worst that eps2 can do.",
        OFF_TARGET,
        lambda s: steps.bounded(s, False),
        BOUND,
    ),
    Claim(
        "eq73",
        (73,),
        PRINTED,
        "the same with -W~'(W~ + W*) <= -|W~|^2/2 + |W*|^2/2; what is left over is "
        "sigma |W^|^2/(2 M1) more",
        "Forgetting pulls the weights back.",
        OFF_TARGET,
        lambda s: steps.bounded(s, True),
        BOUND,
    ),
    Claim(
        "eq82-83",
        (82, 83),
        PRINTED,
        "V3i' <= -(rho1 - 1) V1i/M1 + ... by (73) and (81); one inequality with two numbers",
        "One unit of the gain is spent on eps2.",
        OFF_TARGET + "; V1i >= (v - v_c1)^2/2 by (81)",
        steps.printed_step,
        BOUND,
        premises=("eq81",),
    ),
    Claim(
        "eq84-85",
        (84, 85, 87),
        PRINTED,
        "V3i' <= -rho2 V3i + C_i per axis",
        "Velocity and weight errors fall "
        "until eps2 and the forgetting balance them - provided that eps2 is bounded.",
        OFF_TARGET
        + "; rho2 <= (rho1 - 1)/M1 and rho2 <= sigma Gamma; scalar Gamma; V1i >= (v - v_c1)^2/2",
        steps.decay,
        Ring(DECAY_CASES, spare=0),
        premises=("eq81",),
    ),
    Claim(
        "eq86",
        (86,),
        PRINTED,
        "rho2 of (86) is below (rho1_i - 1)/M1ii and sigma_i Gamma_i on both axes",
        "The slowest of four rates decides: with the paper's gains it is the forgetting, 0.08 1/s, "
        "which rho1 "
        "cannot change.",
        "all gains and masses positive, rho1 > 1",
        steps.rate_is_least,
        Z3(),
    ),
    Claim(
        "eq60.step",
        (60, 88),
        CORRECTED,
        "|z|^2 <= 4 C3/rho2 as soon as V3 <= 2 C3/rho2 (the text after (88) sets "
        "4 C3/rho2 = eps3, which must be eps3^2)",
        "How close the velocities come, if C3 is finite.",
        "|v_c0| < v_u2, so that v_c1 = v_c0 and |z|^2/2 <= V3",
        steps.end_bound,
        Z3(),
        premises=("eq81",),
    ),
)
