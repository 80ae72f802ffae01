"""The adaptive network: Eqs. (57)-(73), (82)-(88), all 64 nodes of one axis on the law's graph.

Inner quantities of the law are free; charts of these are given.
"""

from functools import lru_cache
from typing import Any

from casadi import SX, dot, jtimes, substitute, vertcat

from wmr_ctrl.control.laws import nn
from wmr_ctrl.control.laws.context import LawContext
from wmr_ctrl.world.model.dynamics import acceleration
from wmr_proofs import paper_functions as analysis
from wmr_proofs.claim import CORRECTED, OURS, PRINTED, Claims, Mutation
from wmr_proofs.methods.spec import Z3, Refute, Ring
from wmr_proofs.regions import FREE, NONNEGATIVE, NONZERO, POSITIVE, Case, Values, at, axis_case
from wmr_proofs.statement import Named, Statement, column, equal, every, stacked, symbols

from .common import LawGraph, barrier_axis, named_axes


class NetworkAxis(Named):
    """The network law's graph on one axis, with the barrier's quotients, w and S free.

    ``free``: V1/A, q, w, S, then A, V1, v_c0', F1, the true mass and the best weights W*, and
    ``inner`` their expressions in the graph; S(Z) is ``basis``, W* ``best``, W^ ``weights``, W~ =
    W^ - W* ``error``.  ``weight_rate`` is (W^(k+1) - W^(k))/T, which the explicit step integrates;
    ``residual`` eps2 of Eq. (59), which is used as its definition: the target less W*'S. Under the
    law's force ``barrier_rate`` is V1i' of Eq. (28), ``rate`` V3i', differentiated from (62).
    """

    def __init__(self, axis: int) -> None:
        self.axis, self.law = axis, LawGraph("nn")
        law, t = self.law, self.law.symbols
        names = symbols("quotient q w A V cdot friction mass")
        self.free = f = names | column("S", NODES) | column("best", NODES)
        self.symbols = t | f
        self.basis, self.best = (stacked(f, name, NODES) for name in ("S", "best"))
        self.weights = vertcat(*(t[f"W_hat{axis + 1}[{j + 1}]"] for j in range(NODES)))
        self.error = self.weights - self.best
        self.inner = self._inner(law.context)
        rows = slice(axis * NODES, (axis + 1) * NODES)
        self.weight_rate = (law.system.update[rows] - self.weights) / t["clock.control"]
        target = analysis.network_target(f.mass, f.cdot, f.A / f.w, f.friction)
        self.residual = dot(self.best, self.basis) - target
        v_dot = acceleration(f.mass, law.force[axis], f.friction)  # of the true robot, Eq. (4)
        self.barrier_rate = f.A * v_dot - f.w * f.cdot
        value, weights = SX.sym("V1i"), SX.sym("W", NODES)
        total = analysis.network_lyapunov(value, f.mass, self.gain("Gamma"), weights)
        state = vertcat(value, weights)
        rate = jtimes(total, state, vertcat(self.barrier_rate, self.weight_rate))
        self.rate = substitute(rate, state, vertcat(f.V, self.error))

    def _inner(self, context: LawContext) -> dict[str, SX]:
        basis = nn.corner_basis(nn.regressor(context), context.gain("eta"), context.gain("node"))
        found = {f"S{j + 1}": self.law.own(basis[j]) for j in range(NODES)}
        return self.law.parts(self.axis, "quotient q w") | found

    def gain(self, name: str) -> SX:
        """A gain of this axis."""
        return self.law[f"gains.nn.{name}[{self.axis + 1}]"]

    @property
    def fed(self) -> SX:
        """Decrease of the rate due to the law's feedback."""
        return -self.gain("rho1") / self.free.mass * self.free.V

    def statement(self, *goals: Any) -> Statement:
        """Goals with the graph's inner quantities free."""
        return Statement(self, goals, (), self.inner)


@lru_cache(maxsize=2)
def network_axis(axis: int) -> NetworkAxis:
    """One axis, built once (`forget` in the package drops it)."""
    return NetworkAxis(axis)


def free_chart(n: Values) -> Values:
    """V1/A and q from A, V1 and w."""
    return {"quotient": n["V"] / n["A"], "q": n["w"] / n["A"], **{k: n[k] for k in ("A", "V", "w")}}


def vanishing_chart(n: Values) -> Values:
    """A = 0, which happens only with V1 = 0 and w = 0; the compiled quotients are then limits."""
    return dict.fromkeys(("A", "V", "w"), 0 * n["quotient"]) | n


def residual_chart(n: Values) -> Values:
    """F1 chosen such that eps2 = w - n with a free n; V1 = w^2/2 + p, W* = W^ - E."""
    w = n["y"]
    value, nodes = w**2 / 2 + n["p"], range(1, NODES + 1)
    best = {f"best{j}": n[f"X{j}"] - n[f"E{j}"] for j in nodes}
    weights = {f"W_hat1[{j}]": n[f"X{j}"] for j in nodes}
    learnt = sum((best[f"best{j}"] * n[f"S{j}"] for j in nodes), 0 * w)
    friction = (learnt - n["mass"] * n["cdot"] - (w - n["n"])) * w / n["A"]
    found = {"V": value, "w": w, "quotient": value / n["A"], "q": w / n["A"], "friction": friction}
    kept = ["A", "mass", "cdot", *(f"S{j}" for j in nodes)]
    return found | best | weights | {name: n[name] for name in kept}


def decay_chart(n: Values) -> Values:
    """Both rates of (86) exceed rho2: rho1 = 1 + M (rho2 + a), sigma Gamma = rho2 + b."""
    gains = {"Gamma": n["gamma"], "rho1": 1 + n["mass"] * (n["rho2"] + n["a"])}
    gains["sigma"] = (n["rho2"] + n["b"]) / n["gamma"]
    named = {f"gains.nn.{name}[1]": value for name, value in gains.items()}
    return residual_chart(n) | {"rho2": n["rho2"]} | named


NODES, DIMENSIONS = nn.NODES, 6


def weights_part(n: NetworkAxis, rate: SX) -> SX:
    """M1^-1 Gamma^-1 W~' times a rate."""
    return dot(n.error, rate) / (n.free.mass * n.gain("Gamma"))


TIMED = {"clock.control": POSITIVE}
GAINS = {f"gains.nn.{name}[1]": POSITIVE for name in ("rho1", "Gamma", "sigma")} | TIMED
VECTORS = {f"{name}{j}": FREE for j in range(1, NODES + 1) for name in ("S", "X", "E")}
SOLVED = {"A": NONZERO, "mass": POSITIVE, "cdot": FREE, "y": NONZERO, "n": FREE}
SOLVED |= {"p": NONNEGATIVE, **VECTORS}
DECLARED = {"mass": POSITIVE, **GAINS}
ANYWHERE = Case("A != 0", {"A": NONZERO, "V": FREE, "w": FREE}, free_chart, DECLARED)
AT_ZERO = Case("A = 0", dict.fromkeys(("quotient", "q"), FREE), vanishing_chart, DECLARED)
RATES = dict.fromkeys(("rho2", "gamma"), POSITIVE) | dict.fromkeys(("a", "b"), NONNEGATIVE)


ONE, OFF = (
    Ring((ANYWHERE,), spare=0),
    Ring((Case("A != 0", {"A": NONZERO, "V": FREE, "w": NONZERO}, free_chart, DECLARED),), spare=0),
)
TWO = Ring((ANYWHERE, AT_ZERO), spare=0)
BOUND = Ring((Case("A != 0", SOLVED, residual_chart, GAINS),), spare=0)
claim = Claims(by=ONE, form=PRINTED)


@claim("eq57", (57,))
def law(mutation: Mutation) -> Statement:
    """F = -rho1 V1/A + q W^'S(Z) on the compiled law's graph, 64 nodes.

    The network law that runs is the paper's, with its quotients in cancellation-free form.

    Given: any weights and basis.
    """
    n = network_axis(0)
    written = -n.gain("rho1") * n.free.quotient + mutation * n.free.q * dot(n.weights, n.basis)
    return n.statement(n.law.force[0] == written)


@claim("eq58{of}", (58,), over=named_axes(".angular"))
def adaptation(mutation: Mutation, axis: int) -> Statement:
    """W^' = -Gamma (S(Z) (v - v_c1) + sigma W^), {where} axis, all 64 weights: the compiled Euler
    step integrates it.

    The weights learn from the distance to the target velocity and slowly forget.

    Given: any weights and basis.
    """
    n = network_axis(axis)
    rate = -n.gain("Gamma") * (n.basis * n.free.w + mutation * n.gain("sigma") * n.weights)
    return n.statement(*(n.weight_rate[j] == rate[j] for j in range(NODES)))


@claim(
    "eq58.basis",
    (57, 58),
    form=OURS,
    by=Ring((Case("any Z", declared={"eta": POSITIVE}),), spare=14),
)
def basis_product(mutation: Mutation) -> Statement:
    """the compiled basis (one exponential per dimension more than one) equals exp(-|Z -
    c_j|^2/eta^2) at all 64 nodes.

    The fast evaluation of the network changes nothing.

    Given: any Z and eta; nodes at -1 and 1.
    """
    t = column("z", DIMENSIONS) | symbols("eta")
    z = stacked(t, "z", DIMENSIONS)
    plain = analysis.gaussian_basis(z, t.eta, analysis.corner_centres(DIMENSIONS, mutation))
    return Statement(t, every(nn.corner_basis(z, t.eta, SX(1)), plain))


@claim("eq59.printed", (59,), by=Refute((at(v="7999999/10000000", c=3, u1=1, u2="4/5"),)))
def target_bounded(_: Mutation) -> Statement:
    """the target (59) is bounded on a bounded set of velocities, so that a network can approximate
    it.

    Just below v_u2 with v_c0 = 3 m/s the network would have to give more than a million times the
    friction force: no bounded weights do that. Theorem 2 assumes it, so its bound is empty in the
    middle region.

    Given: |v| <= 0.95 v_u1, |v_c0| <= 3; ratio <= 10^6 for instance.
    """
    a, v, c, u1, _u2 = barrier_axis()
    given = a.inside, 0.95 * u1 >= abs(v), abs(c) <= 3
    return a.states(abs(a.A / a.w) <= 1e6, given=given)


@claim(
    "eq59.ratio",
    (59,),
    form=OURS,
    by=Ring(tuple(axis_case("", "middle+", side) for side in ("zero", "in+"))),
)
def ratio(mutation: Mutation) -> Statement:
    """A/(v - v_c1) = 1 + (v_c0 - v_u2)/(v_u2 - v) for 0 <= v < v_u2, v_u2 < v_c0 <= v_u2 + 1/(v_u1
    - v_u2): it grows without bound as v rises to v_u2.

    The regressor of the network blows up in normal operation, which is why the code caps it.

    Given: every 0 < v_u2 < v_u1.
    """
    a, v, c, _, u2 = barrier_axis()
    return a.states(equal(a.A, a.w * (1 + mutation * (c - u2) / (u2 - v))))


@claim("eq63-66", (62, 63, 64, 65, 66), by=TWO)
def differentiated(mutation: Mutation) -> Statement:
    """differentiating V3i = V1i + W~'W~/(2 M1 Gamma) gives (66).

    How velocity error and learning error change together.

    Given: {ALL_NODES}.
    """
    n = network_axis(0)
    return n.statement(n.rate == n.barrier_rate + mutation * weights_part(n, n.weight_rate))


@claim("eq67-68", (67, 68), by=TWO)
def substituted(mutation: Mutation) -> Statement:
    """with (28), (4) and constant W*.

    Force and friction enter.

    Given: {ALL_NODES}.
    """
    n = network_axis(0)
    f = n.free
    pushed = f.A / f.mass * (n.law.force[0] - f.friction) - mutation * f.w * f.cdot
    return n.statement(n.rate == pushed + weights_part(n, n.weight_rate))


@claim("eq69", (69,), by=TWO)
def with_law(mutation: Mutation) -> Statement:
    """with the law (57).

    The feedback appears as a decay.

    Given: {ALL_NODES}.
    """
    n = network_axis(0)
    f = n.free
    learnt = f.w / f.mass * dot(n.best + n.error, n.basis)
    lost = f.A / f.mass * f.friction + mutation * f.w * f.cdot
    return n.statement(n.rate == n.fed + weights_part(n, n.weight_rate) + learnt - lost)


@claim("eq70", (70,), by=OFF)
def with_target(mutation: Mutation) -> Statement:
    """with (59) as the definition of eps2.

    The part that the network cannot represent remains as eps2.

    Given: {OFF_TARGET}.
    """
    n = network_axis(0)
    f = n.free
    rest = f.w / f.mass * (dot(n.error, n.basis) + mutation * n.residual)
    return n.statement(n.rate == n.fed + weights_part(n, n.weight_rate) + rest)


@claim("eq71", (71,), by=OFF)
def with_adaptation(mutation: Mutation) -> Statement:
    """with the adaptation (58).

    Learning cancels the unknown part; only the forgetting term and eps2 remain.

    Given: {OFF_TARGET}.
    """
    n = network_axis(0)
    mass = n.free.mass
    leak = n.gain("sigma") / mass * dot(n.error, n.weights)
    written = n.fed - mutation * leak + n.free.w / mass * n.residual
    return n.statement(n.rate == written)


@claim(
    "eq{number}",

    by=BOUND,
    over=(
        {"number": 72, "equations": (72,), "combined": False, "more": "",
         "left": "(w - eps2)^2/(2 M1)", "so": "The worst that eps2 can do."},
        {"number": 73, "equations": (73,), "combined": True,
         "more": " and -W~'(W~ + W*) <= -|W~|^2/2 + |W*|^2/2",
         "left": "(w - eps2)^2/(2 M1) + sigma |W^|^2/(2 M1)",
         "so": "Forgetting pulls the weights back."},
    ),
)  # fmt: skip
def eq72(mutation: Mutation, combined: bool) -> Statement:
    """V3i' <= (71) with w eps2 <= w^2/2 + eps2^2/2{more}; what is left over is {left}.

    {so}

    Given: {OFF_TARGET}.
    """
    n = network_axis(0)
    mass, sigma = n.free.mass, n.gain("sigma")
    base = n.fed + 0.5 / mass * (n.free.w**2 + n.residual**2)
    leak = -sigma / mass * dot(n.error, n.error + n.best)
    if combined:
        leak = 0.5 * sigma / mass * (dot(n.best, n.best) - dot(n.error, n.error))
    bound = base + mutation(1, 9) * leak - (mutation < 0) * n.residual**2
    return n.statement(bound >= n.rate)


@claim("eq82-83", (82, 83), by=BOUND, premises="eq81")
def printed_step(mutation: Mutation) -> Statement:
    """V3i' <= -(rho1 - 1) V1i/M1 + ... by (73) and (81); one inequality with two numbers.

    One unit of the gain is spent on eps2.

    Given: {OFF_TARGET}; V1i >= (v - v_c1)^2/2 by (81).
    """
    n = network_axis(0)
    mass = n.free.mass
    bound = -(n.gain("rho1") - mutation(1, -1e6)) / mass * n.free.V + 0.5 / mass * n.residual**2
    leak = 0.5 * n.gain("sigma") / mass * (dot(n.best, n.best) - dot(n.error, n.error))
    return n.statement(bound + leak >= n.rate)


@claim(
    "eq84-85",
    (84, 85, 87),
    by=Ring((Case("rho2 below both rates", SOLVED | RATES, decay_chart, TIMED),), spare=0),
    premises="eq81",
)
def decay(mutation: Mutation) -> Statement:
    """V3i' <= -rho2 V3i + C_i per axis.

    Velocity and weight errors fall until eps2 and the forgetting balance them - provided that eps2
    is bounded.

    Given: {OFF_TARGET}; rho2 <= (rho1 - 1)/M1 and rho2 <= sigma Gamma; scalar Gamma; V1i >= (v -
    v_c1)^2/2.
    """
    n = network_axis(0)
    f = n.free
    leftover = analysis.leftover(n.residual, n.gain("sigma"), n.best, f.mass)
    total = analysis.network_lyapunov(f.V, f.mass, n.gain("Gamma"), n.error)
    names = n.symbols | symbols("rho2")
    least = mutation(names.rho2, 1e6 * names.rho2)
    return Statement(names, -least * total + leftover >= n.rate, (), n.inner)


@claim("eq86", (86,), by=Z3())
def rate_is_least(mutation: Mutation) -> Statement:
    """rho2 of (86) is below (rho1_i - 1)/M1ii and sigma_i Gamma_i on both axes.

    The slowest of four rates decides: with the paper's gains it is the forgetting, 0.08 1/s, which
    rho1 cannot change.

    Given: all gains and masses positive, rho1 > 1.
    """
    t = column("rho", 2) | column("M", 2) | column("sigma", 2) | column("gamma", 2)
    rho, mass, sigma, gamma = (stacked(t, name, 2) for name in ("rho", "M", "sigma", "gamma"))
    least = mutation(1, 2) * analysis.decay_rate(rho, mass, sigma, gamma)
    given = tuple(t[f"{n}{i}"] > 0 for n in ("M", "sigma", "gamma") for i in (1, 2))
    ones = tuple(t[f"rho{i}"] > 1 for i in (1, 2))
    goals = [(rho[i] - 1) / mass[i] >= least for i in (0, 1)]
    goals += [sigma[i] * gamma[i] >= least for i in (0, 1)]
    return Statement(t, goals, given + ones)


@claim("eq60.step", (60, 88), form=CORRECTED, by=Z3(), premises="eq81")
def end_bound(mutation: Mutation) -> Statement:
    """|z|^2 <= 4 C3/rho2 as soon as V3 <= 2 C3/rho2 (the text after (88) sets 4 C3/rho2 = eps3,
    which must be eps3^2).

    How close the velocities come, if C3 is finite.

    Given: |v_c0| < v_u2, so that v_c1 = v_c0 and |z|^2/2 <= V3.
    """
    t = symbols("z1 z2 V C1 C2 rho2")
    z1, z2, V, C1, C2, rho2 = t.values()
    square = z1**2 + z2**2
    given = rho2 > 0, V * rho2 <= 2 * (C1 + C2), square <= 2 * V
    return Statement(t, 4 * (C1 + C2) * mutation(1, 0.5) >= square * rho2, given)
