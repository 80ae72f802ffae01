"""The sampled-data law: its proximal map, the decay of V1 and w, the observer's stability.

The law is v+ = X_(1-E)(E (v + X_1(c+) - X_1(c)) + (1-E) c+).  That X_k is the proximal map of the
barrier is shown on the graph, for both forms of the barrier; what follows for any convex barrier is
algebra about the map's defining property, a LEMMA: nothing of it reads `prox_step` but
`prox.inside`.
"""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.laws.prox import prox_step
from wmr_ctrl.proofs.claim import OURS, Claim
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Relation, Statement, above, at_least, equal, symbols

THEME = "prox"
ANY = "every 0 < v_u2 < v_u1, k > 0 and |c| < 1e100"


def _limits(t: dict[str, ca.SX]) -> tuple[Relation, ...]:
    return above(t["u2"]), above(t["u1"], t["u2"])


def _fixed_point(flip: float) -> Statement:
    """x = X_1(c), a = c - x in df(x): E x + (1-E) c = x + (1-E) a, whose proximal map is x."""
    t = symbols("x c E")
    mixed = t["E"] * t["x"] + flip * (1 - t["E"]) * t["c"]
    return Statement(t, (equal(mixed - t["x"], (1 - t["E"]) * (t["c"] - t["x"])),))


def _contracts(flip: float) -> Statement:
    """The step with its proximal maps as free values m_1, m_2 (X_1 at c, c+): |w+| <= E |w|."""
    t = symbols("v c c_next E m1 m2 end")
    start = t["E"] * (t["v"] + t["m2"] - t["m1"]) + (1 - t["E"]) * t["c_next"]
    rest = t["E"] * t["m2"] + (1 - t["E"]) * t["c_next"]
    apart, w = t["end"] - t["m2"], t["v"] - t["m1"]
    near = at_least((start - rest) ** 2, apart**2)
    goal = at_least((t["E"] * w) ** 2, (1 if flip > 0 else 1.01) * apart**2)
    return Statement(t, (goal,), (near, above(t["E"]), at_least(ca.SX(1), t["E"])))


def _inside(flip: float) -> Statement:
    """|v+| < v_u1 from every v, on the law's graph."""
    t = symbols("v c c_next E u1 u2", "E u1 u2")
    end = prox_step(t["v"], t["c"], t["c_next"], (t["E"], 1 - t["E"]), (t["u1"], t["u2"]), False)
    limit = t["u1"] if flip > 0 else t["u2"]
    given = (*_limits(t), above(t["E"]), above(ca.SX(1), t["E"]))
    return Statement(t, (above(limit, end), above(end, -limit)), given)


def _decay(flip: float) -> Statement:
    """V(v*) >= V(v+) + tau A^2 + tau^2 A^2/2 and V(v+) <= A^2/2 give V(v*) >= (1 + tau)^2 V(v+)."""
    t = symbols("before after A tau")
    square = t["A"] ** 2
    convex = at_least(t["before"], t["after"] + t["tau"] * square + 0.5 * (t["tau"] * t["A"]) ** 2)
    small = at_least(0.5 * square, t["after"])
    factor = (1 + t["tau"]) ** 2 if flip > 0 else (1.01 + t["tau"]) ** 2
    return Statement(
        t,
        (at_least(t["before"], factor * t["after"]),),
        (convex, small, above(t["tau"]), at_least(t["after"])),
    )


def _step_is_implicit(flip: float) -> Statement:
    """v* - v+ = tau A(v+; c+) with tau = 1/E - 1 is the optimality of X_(1-E)."""
    t = symbols("start end slope c E")
    optimal = equal(
        t["E"] * t["start"] + (1 - t["E"]) * t["c"] - t["end"], (1 - t["E"]) * t["slope"]
    )
    A = t["end"] - t["c"] + flip * t["slope"]
    return Statement(
        t, (equal(t["E"] * (t["start"] - t["end"]), (1 - t["E"]) * A),), (optimal, above(t["E"]))
    )


def _bounded_push(flip: float) -> Statement:
    """Continuous limit: A (-(rho/2) A + d/M) <= -(rho/2) V1 + d^2/(rho M^2), from A^2 >= 2 V1."""
    t = symbols("A V1 rho push")
    rate = t["A"] * (-0.5 * t["rho"] * t["A"] + t["push"])
    bound = -0.5 * t["rho"] * t["V1"] + t["push"] ** 2 / t["rho"]
    given = (above(t["rho"]), at_least(t["A"] ** 2, 2 * t["V1"]), at_least(t["V1"]))
    return Statement(t, (at_least(bound, (1 if flip > 0 else -1) * rate),), given)


def _jury(flip: float) -> Statement:
    """Trace and determinant of the loop of (w, T f/M^) are what the rule is read from."""
    t = symbols("mu a L")
    loop = ca.vertcat(
        ca.horzcat(1 - t["mu"] * t["a"], t["mu"]),
        ca.horzcat(-t["L"] * t["a"] * (1 - t["mu"]), 1 - t["L"] * t["mu"]),
    )
    trace, det = loop[0, 0] + loop[1, 1], loop[0, 0] * loop[1, 1] - loop[0, 1] * loop[1, 0]
    edge = 4 - t["mu"] * (2 * (t["a"] + t["L"]) - flip * t["a"] * t["L"])
    return Statement(
        t, (equal(1 + trace + det, edge), equal(1 - trace + det, t["mu"] * t["a"] * t["L"]))
    )


def _light_model(flip: float) -> Statement:
    """M^ <= (4/3) M: all three conditions of Jury, for every rho, T and wo."""
    t = symbols("mu a L")
    given = [part for name in ("a", "L") for part in (above(t[name]), above(ca.SX(1), t[name]))]
    share = 4 / ca.SX(3) if flip > 0 else ca.SX(1.5)
    edge = 4 - t["mu"] * (2 * (t["a"] + t["L"]) - t["a"] * t["L"])
    det = 1 - t["mu"] * (t["a"] + t["L"]) + t["mu"] * t["a"] * t["L"]
    return Statement(
        t, (above(edge), above(ca.SX(1), det)), (*given, above(t["mu"]), at_least(share, t["mu"]))
    )


SLOW = Z3(timeout=60)

CLAIMS = (
    Claim(
        "prox.fixed-point",
        (),
        OURS,
        "E x + (1-E) c - x = (1-E) (c - x) for x = X_1(c), so X_(1-E) maps it to x",
        "On its target the law stays there.",
        "any E, x, c",
        _fixed_point,
        SLOW,
        premises=("prox.optimal",),
        theme=THEME,
    ),
    Claim(
        "prox.inside",
        (),
        OURS,
        "paper's barrier: |v+| < v_u1 for every v, c, c+, over the real numbers",
        "The law never aims beyond the limit, wherever the robot is. In doubles v+ can round to "
        "v_u1 itself (from |c+| of about 1e17 on).",
        "0 < v_u2 < v_u1, 0 < E < 1",
        _inside,
        SLOW,
        theme=THEME,
    ),
    Claim(
        "prox.contracts",
        (),
        OURS,
        "|w+| <= E |w|, w = v - v_c1 before (at c) and after (at c+)",
        "The distance to the target, which may move, shrinks by E in every sample, however long "
        "the sample is.",
        "0 < E <= 1, X_(1-E) not expansive, fixed point at v_c1",
        _contracts,
        SLOW,
        premises=("prox.not-expansive", "prox.fixed-point"),
        theme=THEME,
    ),
    Claim(
        "prox.implicit",
        (),
        OURS,
        "v* - v+ = (1/E - 1) A(v+; c+)",
        "The law is the backward Euler step of V1's gradient flow.",
        "optimality of X_(1-E)",
        _step_is_implicit,
        SLOW,
        premises=("prox.optimal",),
        theme=THEME,
    ),
    Claim(
        "prox.decay",
        (),
        OURS,
        "V1(v+; c+) <= exp(-rho T) V1(v*; c+)",
        "With the target held (v* = v) V1 falls by its rate in a sample, whatever the period. A "
        "target that moves can raise V1 from v to v*, which nothing here bounds.",
        "V1 - v^2/2 convex, A in dV1: at v* and, for V1(v+) <= A^2/2, at v_c1; 1 + tau = 1/E = "
        "exp(rho T/2); model exact",
        _decay,
        SLOW,
        premises=("prox.implicit", "convex", "prox.monotone-smooth"),
        theme=THEME,
    ),
    Claim(
        "prox.bounded-push",
        (),
        OURS,
        "V1' <= -(rho/2) V1 + d^2/(rho M^2) in the limit of short samples",
        "Target held and the period short, a bounded disturbance leaves V1 bounded, hence the "
        "velocity inside: the law has authority.",
        "A^2 >= 2 V1: V1 - v^2/2 convex, at v_c1; v_c0 held, T -> 0",
        _bounded_push,
        SLOW,
        premises=("convex", "prox.monotone-smooth"),
        theme=THEME,
    ),
    Claim(
        "prox.jury",
        (),
        OURS,
        "velocity loop with observer: 1 + tr + det = 4 - mu (2 (a + L) - a L), "
        "1 - tr + det = mu a L",
        "The two numbers that decide the sampled loop's stability.",
        "mu = M^/M, a = 1 - E, L = 1 - exp(-wo T); below v_u2, c constant",
        _jury,
        SLOW,
        theme=THEME,
    ),
    Claim(
        "prox.light-model",
        (),
        OURS,
        "M^ <= (4/3) M makes the velocity loop stable for every rho, T and wo",
        "Believe a mass that is rather too small.",
        "0 < a, L < 1",
        _light_model,
        SLOW,
        premises=("prox.jury",),
        theme=THEME,
    ),
)
