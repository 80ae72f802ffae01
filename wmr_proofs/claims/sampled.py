"""The velocity limits under a held command, rounding of the law's compiled text included.

One control period T: v(next) = v + T (F/M - F1/M + d), with the model-based law's own force F (its
clip of v included), mass exact, d constant over the period, |d| <= D, |v_c0| <= C, |v_c0'| <= R.
The claim is that |v| <= L < v_u1 is kept.  Friction is 0: exactly compensated friction cancels, and
the rounding of adding it is part of d.

With decay = "exact" the period is one Newton step towards V1 exp(-rho T): V1 is shown to lie above
each of its tangents, corner included; the consequence for the step is shown on the law's graph.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import casadi as ca

from wmr_ctrl.world.model.dynamics import acceleration
from wmr_proofs import paper_barrier as barrier
from wmr_proofs.claim import Claims, Mutation, rows
from wmr_proofs.methods.spec import Z3, Ball, Method, Refute, Ring
from wmr_proofs.regions import NONNEGATIVE, SIDE_EDGES, SIDES, Case, Values, at, tangent_case
from wmr_proofs.statement import Cuts, Relations, Statement, between, positive, symbols, within

from .common import BOTH_AXES, VELOCITY_NAMES, LawGraph


@dataclass(frozen=True)
class Held:
    """One setting: axis (0, 1), period, largest |v_c0|, |v_c0'| and |d|, level L, as text."""

    id: str
    axis: int
    period: str
    target: str
    rate: str
    disturbance: str
    level: str

    def statement(self, mutation: Mutation) -> Statement:
        """|next v| <= L; the mutation has eight times the disturbance."""
        law, free = LawGraph("mb"), symbols("c cdot d")
        v, level = law[self.velocity], float(Fraction(self.level))
        nominal = acceleration(law.own(law.context.mass), law.force, ca.SX(0))[self.axis]
        following = v + float(Fraction(self.period)) * (nominal + mutation(1, 8) * free.d)
        inner = law.inner(self.axis)
        del inner[self.velocity]  # the clip stays in the graph
        return Statement(law | free, within(following, level), (), inner, numbers(law))

    @property
    def velocity(self) -> str:
        """Name of the axis's velocity."""
        return VELOCITY_NAMES[self.axis]

    @property
    def unit(self) -> str:
        """Unit of the velocity."""
        return ("m/s", "rad/s")[self.axis]

    @property
    def milliseconds(self) -> str:
        """The period."""
        return f"{float(Fraction(self.period)) * 1000:g}"

    @property
    def method(self) -> Method:
        """Branch and bound over v and v_c0; rate and disturbance stay intervals."""
        names = (self.velocity, "c", "cdot", "d")
        bounds = (self.level, self.target, self.rate, self.disturbance)
        sizes = {name: Fraction(float(Fraction(b))) for name, b in zip(names, bounds, strict=True)}
        # v_u2 and v_u2 + 1/(v_u1 - v_u2) of the preset.
        u1, u2 = (Fraction(float(x)) for x in ((1.0, 0.8), (1.5, 1.3))[self.axis])
        edges = (u2, Fraction(float(u2 + 1 / (u1 - u2))))
        cuts = {
            self.velocity: (-edges[0], Fraction(0), edges[0]),
            "c": (*(-e for e in edges), Fraction(0), *edges),
        }
        box = {name: (-size, size) for name, size in sizes.items()}
        return Ball(box=box, float_mode=True, cuts_at=cuts, split=names[:2], budget=20000)


def numbers(law: LawGraph) -> dict[str, float]:
    """The preset's values of the law's parameters, friction set to 0."""
    names = [name for port in law.system.params for name in port.signal.elements]
    return dict(zip(names, law.system.p0, strict=True)) | {"model.mu": 0.0}


SETTINGS = (
    Held("sampled.1ms", 0, "1/1000", "5", "10", "0.312", "0.9292"),
    Held("sampled.1ms-frozen", 0, "1/1000", "5", "0", "0.677", "0.9292"),
    Held("sampled.1ms-far", 0, "1/1000", "10", "25", "0.131", "0.9653"),
    Held("sampled.1ms-angular", 1, "1/1000", "6", "15", "1.232", "1.4335"),
    Held("sampled.10ms", 0, "1/100", "5", "10", "0.3", "0.9292"),
    Held("sampled.10ms-angular", 1, "1/100", "6", "10", "1.1", "1.4335"),
)
SLOW = tuple(
    {"s": s, "points": tuple(at(**{s.velocity: v}, c=s.target, cdot=0, d=0) for v in speeds)}
    for s, speeds in (
        (Held("sampled.100ms", 0, "1/10", "10", "0", "0.01", "0.9999"),
         ("0", "1/5", "-1/2", "-4/5", "-9/10", "-99/100")),
        (Held("sampled.100ms-angular", 1, "1/10", "6", "0", "0.01", "1.4335"),
         ("0", "1/2", "-1/2", "-1")),
    )
)  # fmt: skip
claim = Claims()


@claim(
    "{s.id}",
    (9,),
    by=lambda s: s.method,
    premises="assumption.libm lemma.sampling",
    over=rows(s=SETTINGS),
)
def held(mutation: Mutation, s: Held) -> Statement:
    """|{s.velocity}| <= {s.level} {s.unit} is kept with T = {s.milliseconds} ms for |v_c0| <=
    {s.target}, |v_c0'| <= {s.rate} and a disturbance of at most {s.disturbance} {s.unit}^2.

    The law's compiled text, with every rounding error that it can make, keeps the limit from one
    sample to the next under the stated disturbance.

    Given: paper limits and gains; mass exact, friction compensated; doubles; log of the C library
    right to 2^-51 (tested); no underflow; the force acts as computed: its conversion to wheel
    torques is not in the graph.
    """
    return s.statement(mutation)


@claim("{s.id}", (9,), by=lambda points: Refute(points), over=SLOW)
def slow(mutation: Mutation, s: Held) -> Statement:
    """|{s.velocity}| <= {s.level} {s.unit} is kept with T = {s.milliseconds} ms for |v_c0| <=
    {s.target}, |v_c0'| <= {s.rate} and a disturbance of at most {s.disturbance} {s.unit}^2.

    With the 100 ms of the paper's experiment and the gains of its simulation one sample is enough
    to break the limit.

    Given: paper limits and gains; mass exact, friction compensated.
    """
    return s.statement(mutation)


def _pairs() -> Iterator[Case]:
    """y and v, each on one of the 7 sides; at corners with smaller jumps, and the largest."""
    for y_side in (*SIDES, *SIDE_EDGES):
        for v_side in (*SIDES, *SIDE_EDGES):
            for jump in ("part", "whole") if v_side in SIDE_EDGES else ("",):
                yield _pair(y_side, v_side, jump)


def _pair(y_side: str, v_side: str, jump: str) -> Case:
    pair = tangent_case(y_side, v_side)

    def values(n: Values) -> Values:
        sizes = {"part": lambda: n["s"] / (1 + n["s"]) / n["b"], "whole": lambda: 1 / n["b"]}
        return {**pair.values(n), "jump": sizes.get(jump, lambda: n["u2"] - n["u2"])()}

    share = {"s": NONNEGATIVE} if jump == "part" else {}
    label = pair.label + (f", {jump} of the jump" if jump else "")
    return Case(label, pair.numbers | share, values)


class NewtonStep:
    """One period of one axis under decay = "exact", with symbols for the law's inner values.

    ``free``: V1/A, q, v_c0', exp(-rho T) - 1; w; V1 and slopes at v (before) and at v+ (after).
    """

    def __init__(self, axis: int) -> None:
        self.axis, self.law = axis, LawGraph("mb", ("gains.mb.decay", "exact"))
        self.free = symbols("quotient q cdot fall w before after slope slope_after")
        self.mass = self.law.own(self.law.context.mass)

    @property
    def cuts(self) -> Cuts:
        """Expressions of the first four, and the friction, which is compensated whatever it is."""
        law, k = self.law, self.axis
        rate = law[f"gains.mb.rho[{k + 1}]"] * law["clock.control"]
        return law.parts(k, "quotient q cdot friction") | {"fall": ca.expm1(-rate)}

    @property
    def moved(self) -> ca.SX:
        """v+ - v with the model exact: F is held over the period, friction compensated."""
        law = self.law
        rate = acceleration(self.mass, law.force, law.own(law.context.friction))[self.axis]
        return law["clock.control"] * rate

    def states(self, goals: Relations, given: Relations) -> Statement:
        """The statement on the law's graph: T > 0, M > 0, v_c0' = 0, 0 < exp(-rho T) < 1."""
        fall = self.free.fall
        held = positive(self.law["clock.control"], self.mass[self.axis]), fall > -1, -fall > 0
        known = held, self.free.cdot == 0, given
        return Statement(self.law | self.free, goals, known, self.cuts)


newton_claim = Claims(given="{HELD}; 0 < exp(-rho T) < 1{NO_SERIES}")


@newton_claim("convex", (12, 80), by=Ring(tuple(_pairs()), log_lemma=True), premises="lemma.log")
def above_tangent(mutation: Mutation) -> Statement:
    """V1i(y) >= V1i(v) + a (y - v) + (y - v)^2/2 with a = A, and at |v| = v_u2 with every slope
    between those of the two sides.

    The barrier function lies above each of its tangents, its corner included.

    Given: every 0 < v_u2 < v_u1, |v| and |y| < v_u1, any v_c0.
    """
    # V1(y) >= V1(v) + (A + jump) (y - v) + (y - v)^2/2; the minimum of (16) stands as any number.
    # ``jump`` is 0 off the corner, and there up to the corner's jump of slope 1/(u1 - u2).
    t = symbols("y v c u1 u2 jump", "u1 u2")
    y, v, c, u1, u2, jump = t.values()
    slope = barrier.a_term(v, c, u1, u2) + ca.if_else(ca.eq(abs(v), u2), barrier.sign(v) * jump, 0)
    bend = mutation(0.5, 0.6) * (y - v) ** 2
    line = barrier.lyapunov(v, c, u1, u2) + slope * (y - v) + bend
    given = jump >= 0, jump * (u1 - u2) <= 1
    least = {"least": -barrier.g(c, u1, u2)}
    return Statement(t, barrier.lyapunov(y, c, u1, u2) >= line, given, least)


@newton_claim("prox.newton-side", by=Z3(), premises="P5", each=BOTH_AXES)
def side(mutation: Mutation, axis: int) -> Statement:
    """on the law's graph v+ lies between v and v_c1, at most exp(-rho T) nearer: exp(-rho T) w^2 <=
    (v+ - v_c1) w <= w^2; on each axis.

    One sample never carries the velocity past its target, whatever the period.
    """
    s = NewtonStep(axis)
    w, fall = s.free.w, s.free.fall
    after, share = w * (w + s.moved), s.free.quotient * w
    return s.states(between((1 + mutation * fall) * w**2, after, w**2), between(0, share, w**2))


@newton_claim(
    "prox.newton",
    by=Z3(),
    premises="prox.newton-side convex forms.quotient P3 eq78 eq18.inside",
    each=BOTH_AXES,
)
def falls(mutation: Mutation, axis: int) -> Statement:
    """one Newton step towards exp(-rho T) V1 makes V1 fall and does not pass that level: exp(-rho
    T) V1(v) <= V1(v+) < V1(v); on each axis.

    The exact-decay option of the model-based law cannot overshoot, whatever the period.  Repeated
    steps towards one level are such steps as well (induction).
    """
    # Tangents at v (towards v+) and at v+ (towards v and v_c1, where V1 = 0).
    s = NewtonStep(axis)
    _, _, _, fall, w, before, after, slope, slope_after = s.free.values()
    given = (
        slope * s.free.quotient == before, slope * w >= before + 0.5 * w**2,
        before >= 0.5 * w**2, after >= before + slope * s.moved,
        before >= after - slope_after * s.moved,
        after - slope_after * (w + s.moved) <= 0, w**2 > 0,
    )  # fmt: skip
    return s.states((before > after, after >= mutation((1 + fall) * before, before)), given)
