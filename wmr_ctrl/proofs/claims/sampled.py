"""Ours: the velocity limits under a held command, rounding of the law's compiled text included.

One control period T: v(next) = v + T (F/M - F1/M + d), with the model-based law's own force F (its
clip of v included), mass exact, d constant over the period, |d| <= D, |v_c0| <= C, |v_c0'| <= R.
The claim is that |v| <= L < v_u1 is kept.  Friction is left at 0: what is compensated exactly drops
out, and the rounding of adding it is part of d.
"""

from dataclasses import dataclass
from fractions import Fraction

import casadi as ca

from wmr_ctrl.model.dynamics import acceleration
from wmr_ctrl.proofs.case import at
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.common import VELOCITY_NAMES, LawGraph
from wmr_ctrl.proofs.methods.spec import Ball, Method, Refute
from wmr_ctrl.proofs.statement import Statement, at_least, symbols


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
        v, level = law.symbols[self.velocity], float(Fraction(self.level))
        nominal = acceleration(law.own(law.context.mass), law.force, ca.SX(0))[self.axis]
        following = v + float(Fraction(self.period)) * (nominal + mutation(1, 8) * free["d"])
        inner = law.inner(self.axis)
        del inner[self.velocity]  # the clip stays in the graph
        goals = (at_least(level, following), at_least(following, -level))
        return Statement({**law.symbols, **free}, goals, (), inner, numbers(law))

    @property
    def velocity(self) -> str:
        """Name of the axis's velocity."""
        return VELOCITY_NAMES[self.axis]

    @property
    def unit(self) -> str:
        """Of that velocity."""
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
        edges = _edges(self.axis)
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


def _edges(axis: int) -> tuple[Fraction, Fraction]:
    """v_u2 and v_u2 + 1/(v_u1 - v_u2) of the preset."""
    u1, u2 = (Fraction(float(x)) for x in ((1.0, 0.8), (1.5, 1.3))[axis])
    return u2, Fraction(float(u2 + 1 / (u1 - u2)))


SETTINGS = (
    Held("sampled.1ms", 0, "1/1000", "5", "10", "0.312", "0.9292"),
    Held("sampled.1ms-frozen", 0, "1/1000", "5", "0", "0.677", "0.9292"),
    Held("sampled.1ms-far", 0, "1/1000", "10", "25", "0.131", "0.9653"),
    Held("sampled.1ms-angular", 1, "1/1000", "6", "15", "1.232", "1.4335"),
    Held("sampled.10ms", 0, "1/100", "5", "10", "0.3", "0.9292"),
    Held("sampled.10ms-angular", 1, "1/100", "6", "10", "1.1", "1.4335"),
)
SLOW = (
    {
        "s": Held("sampled.100ms", 0, "1/10", "10", "0", "0.01", "0.9999"),
        "points": tuple(
            at(v1=v, c=10, cdot=0, d=0) for v in ("0", "1/5", "-1/2", "-4/5", "-9/10", "-99/100")
        ),
    },
    {
        "s": Held("sampled.100ms-angular", 1, "1/10", "6", "0", "0.01", "1.4335"),
        "points": tuple(at(omega=w, c=6, cdot=0, d=0) for w in ("0", "1/2", "-1/2", "-1")),
    },
)
claim = Claims()


@claim(
    "{s.id}",
    (9,),
    given="paper limits and gains; mass exact, friction compensated; doubles; log of the C "
    "library right to 2^-51 (tested); no underflow; the force acts as computed: its conversion to "
    "wheel torques is not in the graph",
    by=lambda s: s.method,
    premises="assumption.libm lemma.sampling",
    over=tuple({"s": setting} for setting in SETTINGS),
)
def held(mutation: Mutation, s: Held) -> Statement:
    """|{s.velocity}| <= {s.level} {s.unit} is kept with T = {s.milliseconds} ms for |v_c0| <=
    {s.target}, |v_c0'| <= {s.rate} and a disturbance of at most {s.disturbance} {s.unit}^2.

    The law's compiled text, with every rounding error that it can make, keeps the limit from one
    sample to the next under the stated disturbance.
    """
    return s.statement(mutation)


@claim(
    "{s.id}",
    (9,),
    given="paper limits and gains; mass exact, friction compensated",
    by=lambda points: Refute(points),
    over=SLOW,
)
def slow(mutation: Mutation, s: Held) -> Statement:
    """|{s.velocity}| <= {s.level} {s.unit} is kept with T = {s.milliseconds} ms for |v_c0| <=
    {s.target}, |v_c0'| <= {s.rate} and a disturbance of at most {s.disturbance} {s.unit}^2.

    With the 100 ms of the paper's experiment and the gains of its simulation one sample is enough
    to break the limit.
    """
    return s.statement(mutation)
