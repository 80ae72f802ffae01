"""The model-based law with decay = "exact": one Newton step towards V1 exp(-rho T).

V1 is shown to lie above each of its tangents, corner included; what that means for the step is then
shown on the law's graph.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import casadi as ca

from wmr_ctrl.barrier import paper as barrier
from wmr_ctrl.model.dynamics import acceleration
from wmr_ctrl.proofs.case import NONNEGATIVE, POSITIVE, Case
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.common import NO_SERIES, LawGraph
from wmr_ctrl.proofs.methods.spec import Z3, Ring
from wmr_ctrl.proofs.regions import CHARTED, SIDE_EDGES, SIDES, side_value
from wmr_ctrl.proofs.statement import Relation, Statement, above, at_least, equal, positive, symbols


def _pairs() -> Iterator[Case]:
    """y and v each on one of the 7 sides; at the corners the jump below its largest, and that."""
    for y_side in (*SIDES, *SIDE_EDGES):
        for v_side in (*SIDES, *SIDE_EDGES):
            for jump in ("part", "whole") if v_side in SIDE_EDGES else ("",):
                yield _pair(y_side, v_side, jump)


def _pair(y_side: str, v_side: str, jump: str) -> Case:
    names = {"u2": POSITIVE, "b": POSITIVE}
    names |= {n: POSITIVE for n, s in (("k", y_side), ("i", v_side)) if s[:-1] in CHARTED}
    names |= {"s": NONNEGATIVE} if jump == "part" else {}

    def values(n: Mapping[str, Any]) -> dict[str, Any]:
        u2, b = n["u2"], n["b"]
        sizes = {"part": lambda: n["s"] / (1 + n["s"]) / b, "whole": lambda: 1 / b}
        y, v = (side_value(side, u2, b, n.get(k, 0)) for side, k in ((y_side, "k"), (v_side, "i")))
        return {"u1": u2 + b, "u2": u2, "y": y, "v": v, "jump": sizes.get(jump, lambda: u2 - u2)()}

    return Case(
        f"y {y_side}, v {v_side}" + (f", {jump} of the jump" if jump else ""), names, values
    )


class NewtonStep:
    """One period of one axis under decay = "exact", with free numbers for the law's inner ones.

    ``free``: V1/A, q, v_c0', exp(-rho T) - 1; w; V1 and slopes at v (before) and at v+ (after).
    """

    def __init__(self, axis: int) -> None:
        self.axis, self.law = axis, LawGraph("mb", (("gains.mb.decay", "exact"),))
        self.free = symbols("quotient q cdot fall w before after slope slope_after")

    @property
    def cuts(self) -> dict[str, ca.SX]:
        """Expressions of the first four, and the friction, which is compensated whatever it is."""
        law, k = self.law, self.axis
        found = law.context.barrier[k]
        rate = law.symbols[f"gains.mb.rho[{k + 1}]"] * law.symbols["clock.control"]
        return {
            "quotient": law.own(found.V1_over_A),
            "q": law.own(found.q),
            "cdot": law.own(law.context.v_c0_dot)[k],
            "fall": ca.expm1(-rate),
            "friction": law.own(law.context.friction)[k],
        }

    @property
    def mass(self) -> ca.SX:
        """Diagonal of M1."""
        return self.law.own(self.law.context.mass)

    @property
    def moved(self) -> ca.SX:
        """v+ - v with the model exact: F is held over the period, friction compensated."""
        law = self.law
        rate = acceleration(self.mass, law.force, law.own(law.context.friction))[self.axis]
        return law.symbols["clock.control"] * rate

    def states(self, goals: tuple[Relation, ...], given: tuple[Relation, ...]) -> Statement:
        """The statement on the law's graph: T > 0, M > 0, v_c0' = 0, 0 < exp(-rho T) < 1."""
        fall, period = self.free["fall"], self.law.symbols["clock.control"]
        held = *positive(period, self.mass[self.axis]), above(fall, -1), above(-fall)
        known = (*held, equal(self.free["cdot"]), *given)
        return Statement({**self.law.symbols, **self.free}, goals, known, self.cuts)


HELD = (
    'paper\'s barrier, decay = "exact", c held, model exact, |v| < v_u1 below the clip; v != v_c1'
)
AXES = (
    {"axis": 0, "of": "", "where": ""},
    {"axis": 1, "of": "-angular", "where": " (angular axis)"},
)
claim = Claims(given=f"{HELD}; 0 < exp(-rho T) < 1{NO_SERIES}")


@claim(
    "convex",
    (12, 80),
    given="every 0 < v_u2 < v_u1, |v| and |y| < v_u1, any v_c0",
    by=Ring(tuple(_pairs()), log_lemma=True),
    premises="lemma.log",
)
def above_tangent(mutation: Mutation) -> Statement:
    """V1i(y) >= V1i(v) + a (y - v) + (y - v)^2/2 with a = A, and at |v| = v_u2 with every slope
    between those of the two sides.

    The barrier function lies above each of its tangents, its corner included.
    """
    # V1(y) >= V1(v) + (A + jump) (y - v) + (y - v)^2/2; the minimum of (16) stands as any number.
    # ``jump`` is 0 off the corner, and there up to the corner's jump of slope 1/(u1 - u2).
    t = symbols("y v c u1 u2 jump", "u1 u2")
    y, v, c, u1, u2, jump = t.values()
    at_corner = ca.if_else(ca.eq(ca.fabs(v), u2), barrier.sign(v) * jump, 0)
    slope = barrier.a_term(v, c, u1, u2) + at_corner
    bend = mutation(0.5, 0.6) * (y - v) ** 2
    line = barrier.lyapunov(v, c, u1, u2) + slope * (y - v) + bend
    given = (at_least(jump), at_least(1, jump * (u1 - u2)))
    least = {"least": -barrier.g(c, u1, u2)}
    return Statement(t, (at_least(barrier.lyapunov(y, c, u1, u2), line),), given, least)


@claim("prox.newton-side{of}", by=Z3(), premises="P5", over=AXES)
def side(mutation: Mutation, axis: int) -> Statement:
    """on the law's graph v+ lies between v and v_c1, at most exp(-rho T) nearer: exp(-rho T) w^2 <=
    (v+ - v_c1) w <= w^2{where}.

    One sample never carries the velocity past its target, whatever the period.
    """
    s = NewtonStep(axis)
    w, fall = s.free["w"], s.free["fall"]
    after, share = w * (w + s.moved), s.free["quotient"] * w
    goals = (at_least(after, (1 + mutation * fall) * w**2), at_least(w**2, after))
    return s.states(goals, (at_least(share), at_least(w**2, share)))


@claim(
    "prox.newton{of}",
    by=Z3(),
    premises="prox.newton-side{of} convex forms.quotient P3 eq78 eq18.inside",
    over=AXES,
)
def falls(mutation: Mutation, axis: int) -> Statement:
    """one Newton step towards exp(-rho T) V1 makes V1 fall and does not pass that level: exp(-rho
    T) V1(v) <= V1(v+) < V1(v){where}.

    The exact-decay option of the model-based law cannot overshoot, whatever the period. Steps
    repeated towards one level are each such a step (induction).
    """
    # Tangents at v (towards v+) and at v+ (towards v and v_c1, where V1 = 0).
    s = NewtonStep(axis)
    _, _, _, fall, w, before, after, slope, slope_after = s.free.values()
    given = (
        equal(slope * s.free["quotient"], before),
        at_least(slope * w, before + 0.5 * w**2),
        at_least(before, 0.5 * w**2),
        at_least(after, before + slope * s.moved),
        at_least(before, after - slope_after * s.moved),
        at_least(0, after - slope_after * (w + s.moved)),
        above(w**2),
    )
    level = mutation((1 + fall) * before, before)
    return s.states((above(before, after), at_least(after, level)), given)
