"""Ours: near the limit law (9) resists no disturbance, so its velocity error has no finite gain
from one.

For every bound D > 0 of the disturbing force there is a velocity v* < v_u1 from which a constant D
drives the robot over its limit, with constant v_c0 and an exact model:

    v* = v_u1 - delta g^2,    1/g = 3 + 2 delta B + (rho M/D) (8 delta + B),
    delta = v_u1 - v_u2,      B = v_u1 + |v_c0|

because V1/A falls to 0 there like the square root of the distance to the limit, or faster.  The
altered claims have the gradient law v' = -(rho/2) A + d/M in place of (9): they are refuted.
"""

from fractions import Fraction
from typing import Any

from casadi import SX, if_else, sqrt

from wmr_ctrl.control.barrier.stable import Axis, SmoothAxis, smooth_barrier
from wmr_ctrl.world.model.dynamics import acceleration
from wmr_proofs import regions
from wmr_proofs.claim import Claims, Mutation, rows
from wmr_proofs.methods.spec import Point, Ring, Table
from wmr_proofs.regions import NONNEGATIVE, POSITIVE, Case, Values
from wmr_proofs.statement import Cuts, Group, Statement, positive, symbols

from .authority_table import AXES, Numbers
from .common import CLOSED_FORM, BarrierAxis, LawGraph, barrier_axis
from .sampled import SETTINGS


def reach(delta: Any, B: Any) -> Any:
    """Factor of rho M/D in v*: 8 delta + B."""
    return 8 * delta + B


def level(c: SX, u1: SX, u2: SX, k: SX) -> SX:
    """v* for k = rho M/D."""
    delta, B = u1 - u2, u1 + abs(c)
    return u1 - delta / (3 + 2 * delta * B + k * reach(delta, B)) ** 2


def smaller_slope(a: BarrierAxis) -> SX:
    """A - 1/delta: the slope of the smooth barrier for v > v_u2, below that of the paper's."""
    return a.A - 1 / (a.all[2] - a.all[3])


def near_limit(sign: int) -> Case:
    """v_c0 = sign m; 1/g = 3 + 2 b B + e; rho M/D = e/((8 b + B)(1 + i)), up to what v* allows."""

    def values(n: Values) -> Values:
        u2, b, B = n["u2"], n["b"], n["u2"] + n["b"] + n["m"]
        k = n["e"] / (reach(b, B) * (1 + n["i"]))
        v = u2 + b - b / (3 + 2 * b * B + n["e"]) ** 2
        put = {"u1": u2 + b, "u2": u2, "c": sign * n["m"], "v": v, "rho": k * n["D"] / n["M"]}
        return put | {name: n[name] for name in ("M", "D")}

    numbers = dict.fromkeys(("u2", "b", "e", "D", "M"), POSITIVE)
    ends = dict.fromkeys(("m", "i"), NONNEGATIVE)
    return Case(f"v_c0 {'>=' if sign > 0 else '<='} 0, v >= v*", numbers | ends, values)


def charted(target: str) -> Case:
    """Region near the limit with v_c0 in one of its regions, for any rho M/D."""

    def values(n: Values) -> Values:
        u2, b = n["u2"], n["b"]
        c = regions.target_value(target, u2, b, n.get("j", 0))
        B = u2 + b + (-c if target.endswith("-") else c)
        return {"u1": u2 + b, "u2": u2, "c": c, "v": u2 + b - b / (3 + 2 * b * B + n["e"]) ** 2}

    names = ("u2", "b", "e", *(("j",) if target[:-1] in regions.CHARTED else ()))
    return Case(f"v_c0 {target}, v >= v*", dict.fromkeys(names, POSITIVE), values)


INNER = "quotient q w cdot"


def held_back() -> list[Point]:
    """d_max and the velocity at which it is reached, for v_c0 = 0 to 20; the sampled settings for
    v_c0 = 0 and the largest.
    """
    found = []
    for n in AXES:
        for c in map(float, range(21)):
            v, low = n.best(c)
            found.append(_point(n, v=v, c=c, low=low))
    for s in SETTINGS:
        for farthest in ("0", s.target):
            found.append(_point(AXES[s.axis], v=s.level, c=farthest, low=s.disturbance))
    return found


def _point(n: Numbers, **values: float | str) -> Point:
    return {name: Fraction(x) for name, x in {**values, **vars(n)}.items()}


claim = Claims(given="every 0 < v_u2 < v_u1, any |v_c0| < 1e100")


@claim("gain.ceiling", (12, 16), by=Ring(regions.all_cases(), log_lemma=True), premises="lemma.log")
def ceiling(mutation: Mutation) -> Statement:
    """V1i <= (v - v_c0)^2/2 + f(v).

    The barrier function grows no faster than its logarithm.

    Given: {ALL_LIMITS}.
    """
    a, v, c, _, _ = barrier_axis()
    J = a.cost(v)
    return a.states(mutation(J, J - 0.1 * (v - c) ** 2) >= a.V)


@claim(
    "gain.ceiling-smooth",
    by=Ring(regions.smooth_cases(sides=("out+",)), CLOSED_FORM, log_lemma=True),
    premises="lemma.log",
)
def ceiling_smooth(mutation: Mutation) -> Statement:
    """the same for the smooth barrier as compiled, and its A is the paper's less 1/(v_u1 - v_u2),
    for v > v_u2.

    The same for the smooth barrier.

    Given: every 0 < v_u2 < v < v_u1, any v_c0{NO_SERIES}.
    """
    # For v > v_u2, as compiled; (v - v_c1)/q is the slope.
    a, v, c, u1, u2 = barrier_axis()
    found = smooth_barrier(c, v, u1, u2)
    return a.states(a.cost(v) >= found.V1, found.w == mutation * found.q * smaller_slope(a))


@claim(
    "gain.fades",
    (9, 10, 15),
    by=Ring((near_limit(1), near_limit(-1)), log_lemma=True),
    premises="gain.cover lemma.log",
)
def fades(mutation: Mutation) -> Statement:
    """rho M ((v - v_c0)^2/2 + f(v)) <= (D/2) (A - 1/(v_u1 - v_u2)) and A > 1/(v_u1 - v_u2) for
    every v in [v*, v_u1).

    However small a disturbing force is, close enough to the limit the barrier's share of the law
    resists less than half of it.

    Given: every 0 < v_u2 < v_u1, rho, M, D > 0, any v_c0; {STAR}.
    """
    a, v, c, u1, u2 = barrier_axis()
    t = symbols("rho M D", "rho M")
    A = smaller_slope(a)
    goals = A > 0, t.rho * t.M * mutation(a.cost(v), 0.5 * A**2) <= 0.5 * t.D * A
    given = u1 > v, v >= level(c, u1, u2, t.rho * t.M / t.D)
    return a.states(goals, given=given, more=t)


@claim(
    "gain.closed{key}",
    by=lambda targets: Ring(tuple(map(charted, targets))),
    premises="gain.cover",
    over=rows(
        key=("", "-smooth"), equations=((15,), ()), words=("paper's", "smooth"),
        form=(Axis, SmoothAxis),
        targets=(regions.TARGETS + regions.TARGET_EDGES, regions.SMOOTH_TARGETS),
    ),
)  # fmt: skip
def gain_closed(mutation: Mutation, form: type[Axis]) -> Statement:
    """on [v*, v_u1) the {words} barrier as compiled evaluates phi at Y > 1/2, in closed form.

    There the logarithm itself is evaluated, not its series.
    """
    a, v, c, u1, u2 = barrier_axis()
    s = if_else(c >= 0, 1, -1)
    return a.states(form(s * c, s * v, u1, u2).y > mutation(0.5, 1))


@claim("gain.cover")
def covered(mutation: Mutation) -> Statement:
    """the chart of gain.fades and gain.closed covers all of [v*, v_u1).

    Nothing was left out.

    Given: every 0 < v_u2 < v_u1, k = rho M/D > 0, any v_c0.
    """
    # The numbers e and i that give a point of [v*, v_u1) back.
    a, v, c, u1, u2 = barrier_axis()
    k = SX.sym("k")
    b, B = u1 - u2, u1 + abs(c)
    root = sqrt(b / (u1 - v))
    e = root - 3 - mutation(2, 5) * b * B
    goals = e > 0, e >= reach(b, B) * k, u1 - b / root**2 == v
    given = u2 > 0, u1 > u2, u1 > v, k > 0, v >= level(c, u1, u2, k)
    return Statement(a | {"k": k}, goals, given)


@claim(
    "gain.none{key}",

    premises="gain.fades {parts}",
    over=(
        {"key": "", "equations": (9,), "words": "paper's", "form": "paper",
         "parts": "gain.ceiling gain.closed forms.quotient"},
        {"key": "-smooth", "equations": (), "words": "smooth", "form": "smooth",
         "parts": "gain.ceiling-smooth gain.closed-smooth smooth.quotient"},
    ),
)  # fmt: skip
def gain_none(mutation: Mutation, form: str) -> Statement:
    """on the graph of the model-based law with the {words} barrier v' >= D/(2 M) for every v in
    [v*, v_u1), both axes.

    From v* on, law (9) lets a constant force D > 0 drive the robot outwards all the way, however
    small D is. The gradient law in its place does not (the altered claim).

    Given: v_c0 held, model exact, v below the clip; {STAR}; mirrored at -v_u1.
    """
    law = LawGraph("mb", ("gains.mb.barrier", form))
    mass, friction = law.own(law.context.mass), law.own(law.context.friction)
    every, cuts = dict(law), Cuts()
    goals, given = Group(), Group()
    for axis in (0, 1):
        t = symbols(" ".join(f"{name}{axis + 1}" for name in f"A J D {INNER}".split()))
        A, J, D, quotient, _, _, c_dot = t.values()
        rho = law[f"gains.mb.rho[{axis + 1}]"]
        cuts |= {f"{name}{axis + 1}": part for name, part in law.parts(axis, INNER).items()}
        cuts[f"friction{axis + 1}"] = friction[axis]
        rate = mutation(acceleration(mass[axis], law.force[axis], friction[axis]), -0.5 * rho * A)
        goals.append(rate + D / mass[axis] >= 0.5 * D / mass[axis])
        # A (V1/A) = V1 <= J, and what gain.fades says of J; v_c0 held.
        given += [A > 0, A * quotient <= J, rho * mass[axis] * J <= 0.5 * D * A]
        given += [D > 0, c_dot == 0, positive(mass[axis], rho)]
        every |= t
    return Statement(every, goals, given, cuts)


@claim(
    "gain.levels",
    (9,),
    by=Table(points=held_back),
    premises="authority.lower-linear authority.lower-angular",
)
def levels(mutation: Mutation) -> Statement:
    """v* for D/M = d_max is larger than the velocity at which the law withstands d_max, for v_c0 =
    0, 1, ..., 20 on both axes, and v* for each sampled setting (sampled.*) is larger than its
    level.

    The two results do not contradict each other: the disturbance withstood from below, and the one
    that wins from v* on.

    Given: paper limits and gains.
    """
    # v* of a disturbance that is held back at v lies beyond v; low = D/M.
    t = symbols("v c u1 u2 rho low", "u1 u2 rho")
    return Statement(t, mutation * (level(t.c, t.u1, t.u2, t.rho / t.low) - t.v) > 0)
