"""Statements about the adaptive network, Eqs. (57)-(73), (82)-(88), and their cases."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import casadi as ca

from wmr_ctrl.barrier import lyapunov as analysis
from wmr_ctrl.laws import nn, rbf
from wmr_ctrl.model.dynamics import acceleration
from wmr_ctrl.proofs.claims.common import BarrierAxis, LawGraph
from wmr_ctrl.proofs.statement import (
    Statement,
    above,
    at_least,
    column,
    equal,
    every,
    stacked,
    symbols,
)

NODES, DIMENSIONS = nn.NODES, 6


@dataclass(frozen=True)
class NetworkAxis:
    """The network law's graph on one axis, with the barrier's quotients, w and S free."""

    axis: int = 0

    @cached_property
    def law(self) -> LawGraph:
        """The law."""
        return LawGraph("nn")

    @cached_property
    def free(self) -> dict[str, ca.SX]:
        """V1/A, q, w, S, then A, V1, v_c0', F1, the true mass and the best weights W*."""
        names = "quotient q w A V cdot friction mass"
        return {**symbols(names), **column("S", NODES), **column("best", NODES)}

    @cached_property
    def names(self) -> dict[str, ca.SX]:
        """Everything, the law's own ports included."""
        return {**self.law.symbols, **self.free}

    @cached_property
    def inner(self) -> dict[str, ca.SX]:
        """What the free symbols stand for in the graph."""
        law, sample = self.law, self.law.sample
        axis = sample.barrier[self.axis]
        basis = rbf.corner_basis(nn.regressor(sample), sample.gain("eta"), sample.gain("node"))
        found = {"quotient": axis.V1_over_A, "q": axis.q, "w": axis.w}
        found |= {f"S{j + 1}": basis[j] for j in range(NODES)}
        return {name: law.own(expr) for name, expr in found.items()}

    def gain(self, name: str) -> ca.SX:
        """A gain of this axis."""
        return self.law.symbols[f"gains.nn.{name}[{self.axis + 1}]"]

    @property
    def weights(self) -> ca.SX:
        """W^ of this axis."""
        return self._weight_rows(lambda name: self.law.symbols[name])

    def _weight_rows(self, look_up: Any) -> ca.SX:
        return ca.vertcat(*(look_up(f"W_hat{self.axis + 1}[{j + 1}]") for j in range(NODES)))

    @property
    def weight_rate(self) -> ca.SX:
        """(W^(k+1) - W^(k))/T: the rate that the explicit step integrates."""
        rows = slice(self.axis * NODES, (self.axis + 1) * NODES)
        return (self.law.system.update[rows] - self.weights) / self.law.symbols["clock.control"]

    @property
    def basis(self) -> ca.SX:
        """S(Z)."""
        return stacked(self.free, "S", NODES)

    @property
    def best(self) -> ca.SX:
        """W*."""
        return stacked(self.free, "best", NODES)

    @property
    def error(self) -> ca.SX:
        """W~ = W^ - W*."""
        return self.weights - self.best

    @cached_property
    def v_dot(self) -> ca.SX:
        """Acceleration of the true robot under the law's force, Eq. (4)."""
        return acceleration(self.free["mass"], self.law.force[self.axis], self.free["friction"])

    @cached_property
    def residual(self) -> ca.SX:
        """eps2 of Eq. (59), taken as its definition: what W*'S misses of the target."""
        f = self.free
        target = analysis.network_target(f["mass"], f["cdot"], f["A"] / f["w"], f["friction"])
        return dot(self.best, self.basis) - target

    @cached_property
    def barrier_rate(self) -> ca.SX:
        """V1i' of Eq. (28)."""
        return self.free["A"] * self.v_dot - self.free["w"] * self.free["cdot"]

    @cached_property
    def rate(self) -> ca.SX:
        """V3i' by differentiation of Eq. (62)."""
        value, weights = ca.SX.sym("V1i"), ca.SX.sym("W", NODES)
        total = analysis.network_lyapunov(value, self.free["mass"], self.gain("Gamma"), weights)
        arguments, direction = (
            ca.vertcat(value, weights),
            ca.vertcat(self.barrier_rate, self.weight_rate),
        )
        rate = ca.jtimes(total, arguments, direction)
        return ca.substitute(rate, arguments, ca.vertcat(self.free["V"], self.error))

    def statement(self, *goals: Any) -> Statement:
        """Goals with the graph's inner quantities free."""
        return Statement(self.names, goals, (), self.inner)


@lru_cache(maxsize=2)
def network_axis(axis: int) -> NetworkAxis:
    """One axis, built once (`forget` in the package drops it)."""
    return NetworkAxis(axis)


def dot(left: ca.SX, right: ca.SX) -> ca.SX:
    """Inner product."""
    return ca.dot(left, right)


def law(flip: float) -> Statement:
    """Eq. (57) on the law's graph."""
    n = network_axis(0)
    written = -n.gain("rho1") * n.free["quotient"] + flip * n.free["q"] * dot(n.weights, n.basis)
    return n.statement(equal(n.law.force[0], written))


def adaptation(flip: float, axis: int = 0) -> Statement:
    """Eq. (58) on the law's graph, all weights of one axis."""
    n = network_axis(axis)
    rate = -n.gain("Gamma") * (n.basis * n.free["w"] + flip * n.gain("sigma") * n.weights)
    return n.statement(*(equal(n.weight_rate[j], rate[j]) for j in range(NODES)))


def weights_part(n: NetworkAxis, rate: ca.SX) -> ca.SX:
    """M1^-1 Gamma^-1 W~' times a rate."""
    return dot(n.error, rate) / (n.free["mass"] * n.gain("Gamma"))


def differentiated(flip: float) -> Statement:
    """Eqs. (63), (65), (66): V3i' = V1i' + M1^-1 Gamma^-1 W~' W~'."""
    n = network_axis(0)
    return n.statement(equal(n.rate, n.barrier_rate + flip * weights_part(n, n.weight_rate)))


def substituted(flip: float) -> Statement:
    """Eqs. (67), (68): with (28) and (4)."""
    n = network_axis(0)
    f = n.free
    pushed = f["A"] / f["mass"] * (n.law.force[0] - f["friction"])
    return n.statement(
        equal(n.rate, pushed - flip * f["w"] * f["cdot"] + weights_part(n, n.weight_rate))
    )


def with_law(flip: float) -> Statement:
    """Eq. (69): with (57)."""
    n = network_axis(0)
    f = n.free
    learnt = f["w"] / f["mass"] * dot(n.best + n.error, n.basis)
    lost = f["A"] / f["mass"] * f["friction"] + flip * f["w"] * f["cdot"]
    fed = -n.gain("rho1") / f["mass"] * f["V"]
    return n.statement(equal(n.rate, fed + weights_part(n, n.weight_rate) + learnt - lost))


def with_target(flip: float) -> Statement:
    """Eq. (70): with (59) as the definition of eps2."""
    n = network_axis(0)
    f = n.free
    rest = f["w"] / f["mass"] * (dot(n.error, n.basis) + flip * n.residual)
    fed = -n.gain("rho1") / f["mass"] * f["V"]
    return n.statement(equal(n.rate, fed + weights_part(n, n.weight_rate) + rest))


def with_adaptation(flip: float) -> Statement:
    """Eq. (71): with (58)."""
    n = network_axis(0)
    f, mass = n.free, n.free["mass"]
    leak = n.gain("sigma") / mass * dot(n.error, n.weights)
    written = -n.gain("rho1") / mass * f["V"] - flip * leak + f["w"] / mass * n.residual
    return n.statement(equal(n.rate, written))


def bounded(flip: float, combined: bool) -> Statement:
    """Eqs. (72), (73), the latter with the weights' product bounded: what is left is >= 0."""
    n = network_axis(0)
    f, mass, sigma = n.free, n.free["mass"], n.gain("sigma")
    base = -n.gain("rho1") / mass * f["V"] + 0.5 / mass * (f["w"] ** 2 + n.residual**2)
    leak = -sigma / mass * dot(n.error, n.error + n.best)
    if combined:
        leak = 0.5 * sigma / mass * (dot(n.best, n.best) - dot(n.error, n.error))
    return n.statement(
        at_least(base + (1 if flip > 0 else 9) * leak - (flip < 0) * n.residual**2, n.rate)
    )


def decay(flip: float) -> Statement:
    """Eqs. (82)-(85), (87): V3i' <= -rho2 V3i + C_i for any rho2 below both of (86)."""
    n = network_axis(0)
    f = n.free
    leftover = analysis.leftover(n.residual, n.gain("sigma"), n.best, f["mass"])
    total = analysis.network_lyapunov(f["V"], f["mass"], n.gain("Gamma"), n.error)
    names = {**n.names, **symbols("rho2")}
    least = names["rho2"] if flip > 0 else 1e6 * names["rho2"]
    return Statement(names, (at_least(-least * total + leftover, n.rate),), (), n.inner)


def printed_step(flip: float) -> Statement:
    """Eqs. (82), (83): with (81) in (73)."""
    n = network_axis(0)
    f, mass, sigma = n.free, n.free["mass"], n.gain("sigma")
    bound = (
        -(n.gain("rho1") - (1 if flip > 0 else -1e6)) / mass * f["V"] + 0.5 / mass * n.residual**2
    )
    leak = 0.5 * sigma / mass * (dot(n.best, n.best) - dot(n.error, n.error))
    return n.statement(at_least(bound + leak, n.rate))


def rate_is_least(flip: float) -> Statement:
    """Eq. (86): rho2 is below each of the four rates."""
    t = {**column("rho", 2), **column("M", 2), **column("sigma", 2), **column("gamma", 2)}
    rho, mass, sigma, gamma = (stacked(t, name, 2) for name in ("rho", "M", "sigma", "gamma"))
    least = (1 if flip > 0 else 2) * analysis.decay_rate(rho, mass, sigma, gamma)
    given = tuple(above(t[f"{n}{i}"]) for n in ("M", "sigma", "gamma") for i in (1, 2))
    ones = tuple(above(t[f"rho{i}"], 1) for i in (1, 2))
    goals = [at_least((rho[i] - 1) / mass[i], least) for i in (0, 1)]
    goals += [at_least(sigma[i] * gamma[i], least) for i in (0, 1)]
    return Statement(t, tuple(goals), given + ones)


def end_bound(flip: float) -> Statement:
    """Eqs. (60), (88): once V3 <= 2 C3/rho2, |z| <= sqrt(4 C3/rho2) where v_c1 = v_c0."""
    t = symbols("z1 z2 V C1 C2 rho2")
    square = t["z1"] ** 2 + t["z2"] ** 2
    given = (
        above(t["rho2"]),
        at_least(2 * (t["C1"] + t["C2"]), t["V"] * t["rho2"]),
        at_least(2 * t["V"], square),
    )
    return Statement(
        t,
        (at_least(4 * (t["C1"] + t["C2"]) * (1 if flip > 0 else 0.5), square * t["rho2"]),),
        given,
    )


def ratio(flip: float) -> Statement:
    """A/(v - v_c1) = 1 + (|v_c0| - v_u2)/(v_u2 - v) below v_u2, v_c0 in the middle region."""
    a = BarrierAxis()
    v, c, _, u2 = a.all
    return Statement(a.symbols, (equal(a.A, a.w * (1 + flip * (c - u2) / (u2 - v))),))


def target_bounded(_: float) -> Statement:
    """Eq. (59): the target's ratio is bounded, by a million for instance."""
    a = BarrierAxis()
    v, c, u1 = a.all[:3]
    given = (*a.inside, at_least(0.95 * u1, ca.fabs(v)), at_least(3, ca.fabs(c)))
    return Statement(a.symbols, (at_least(1e6, ca.fabs(a.A / a.w)),), given)


def basis_product(flip: float) -> Statement:
    """The compiled basis against its definition at every node."""
    t = {**column("z", DIMENSIONS), **symbols("eta")}
    z = stacked(t, "z", DIMENSIONS)
    plain = rbf.gaussian_basis(z, t["eta"], rbf.corner_centres(DIMENSIONS, flip))
    return Statement(t, every(rbf.corner_basis(z, t["eta"], ca.SX(1)), plain))


def free_chart(n: Mapping[str, Any]) -> dict[str, Any]:
    """V1/A and q from A, V1 and w."""
    return {"quotient": n["V"] / n["A"], "q": n["w"] / n["A"], **{k: n[k] for k in ("A", "V", "w")}}


def vanishing_chart(n: Mapping[str, Any]) -> dict[str, Any]:
    """A = 0, which happens only with V1 = 0 and w = 0; the compiled quotients are then limits."""
    return {
        "A": 0 * n["quotient"],
        "V": 0 * n["quotient"],
        "w": 0 * n["quotient"],
        "quotient": n["quotient"],
        "q": n["q"],
    }


def residual_chart(n: Mapping[str, Any]) -> dict[str, Any]:
    """F1 chosen such that eps2 = w - n with a free n; V1 = w^2/2 + p, W* = W^ - E."""
    w = n["y"]
    value = w**2 / 2 + n["p"]
    best = {f"best{j}": n[f"X{j}"] - n[f"E{j}"] for j in range(1, NODES + 1)}
    weights = {f"W_hat1[{j}]": n[f"X{j}"] for j in range(1, NODES + 1)}
    learnt = sum((best[f"best{j}"] * n[f"S{j}"] for j in range(1, NODES + 1)), 0 * w)
    friction = (learnt - n["mass"] * n["cdot"] - (w - n["n"])) * w / n["A"]
    found = {"V": value, "w": w, "quotient": value / n["A"], "q": w / n["A"], "friction": friction}
    kept = ["A", "mass", "cdot", *(f"S{j}" for j in range(1, NODES + 1))]
    return {**found, **best, **weights, **{name: n[name] for name in kept}}


def decay_chart(n: Mapping[str, Any]) -> dict[str, Any]:
    """Both rates of (86) exceed rho2: rho1 = 1 + M (rho2 + a), sigma Gamma = rho2 + b."""
    gamma = n["gamma"]
    return {
        **residual_chart(n),
        "rho2": n["rho2"],
        "gains.nn.Gamma[1]": gamma,
        "gains.nn.rho1[1]": 1 + n["mass"] * (n["rho2"] + n["a"]),
        "gains.nn.sigma[1]": (n["rho2"] + n["b"]) / gamma,
    }
