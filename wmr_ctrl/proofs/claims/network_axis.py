"""One axis of the adaptive network's law with its inner quantities free, and charts of these."""

from collections.abc import Mapping
from functools import cached_property, lru_cache
from typing import Any

import casadi as ca

from wmr_ctrl.barrier import lyapunov as analysis
from wmr_ctrl.laws import nn
from wmr_ctrl.model.dynamics import acceleration
from wmr_ctrl.proofs.claims.common import LawGraph
from wmr_ctrl.proofs.statement import Statement
from wmr_ctrl.proofs.symbols import Symbols, column, stacked, symbols


class NetworkAxis:
    """The network law's graph on one axis, with the barrier's quotients, w and S free.

    ``free``: V1/A, q, w, S, then A, V1, v_c0', F1, the true mass and the best weights W*; S(Z) is
    ``basis``, W* ``best``.
    """

    def __init__(self, axis: int) -> None:
        self.axis, self.law = axis, LawGraph("nn")
        names = "quotient q w A V cdot friction mass"
        self.free = symbols(names) | column("S", NODES) | column("best", NODES)
        self.basis, self.best = (stacked(self.free, name, NODES) for name in ("S", "best"))

    @property
    def names(self) -> Symbols:
        """Everything, the law's own ports included."""
        return self.law.symbols | self.free

    @cached_property
    def weights(self) -> ca.SX:
        """W^ of this axis."""
        names = (f"W_hat{self.axis + 1}[{j + 1}]" for j in range(NODES))
        return ca.vertcat(*(self.law.symbols[name] for name in names))

    @property
    def error(self) -> ca.SX:
        """W~ = W^ - W*."""
        return self.weights - self.best

    @cached_property
    def inner(self) -> dict[str, ca.SX]:
        """Expressions of the free symbols in the graph."""
        law, context = self.law, self.law.context
        axis = context.barrier[self.axis]
        basis = nn.corner_basis(nn.regressor(context), context.gain("eta"), context.gain("node"))
        found = {"quotient": axis.V1_over_A, "q": axis.q, "w": axis.w}
        found |= {f"S{j + 1}": basis[j] for j in range(NODES)}
        return {name: law.own(expr) for name, expr in found.items()}

    def gain(self, name: str) -> ca.SX:
        """A gain of this axis."""
        return self.law.symbols[f"gains.nn.{name}[{self.axis + 1}]"]

    @property
    def weight_rate(self) -> ca.SX:
        """(W^(k+1) - W^(k))/T: the rate that the explicit step integrates."""
        rows = slice(self.axis * NODES, (self.axis + 1) * NODES)
        return (self.law.system.update[rows] - self.weights) / self.law.symbols["clock.control"]

    @cached_property
    def v_dot(self) -> ca.SX:
        """Acceleration of the true robot under the law's force, Eq. (4)."""
        return acceleration(self.free.mass, self.law.force[self.axis], self.free.friction)

    @cached_property
    def residual(self) -> ca.SX:
        """eps2 of Eq. (59), taken as its definition: what W*'S misses of the target."""
        f = self.free
        target = analysis.network_target(f.mass, f.cdot, f.A / f.w, f.friction)
        return ca.dot(self.best, self.basis) - target

    @cached_property
    def barrier_rate(self) -> ca.SX:
        """V1i' of Eq. (28)."""
        return self.free.A * self.v_dot - self.free.w * self.free.cdot

    @cached_property
    def rate(self) -> ca.SX:
        """V3i' by differentiation of Eq. (62)."""
        value, weights = ca.SX.sym("V1i"), ca.SX.sym("W", NODES)
        total = analysis.network_lyapunov(value, self.free.mass, self.gain("Gamma"), weights)
        arguments, direction = (
            ca.vertcat(value, weights),
            ca.vertcat(self.barrier_rate, self.weight_rate),
        )
        rate = ca.jtimes(total, arguments, direction)
        return ca.substitute(rate, arguments, ca.vertcat(self.free.V, self.error))

    def statement(self, *goals: Any) -> Statement:
        """Goals with the graph's inner quantities free."""
        return Statement(self.names, goals, (), self.inner)


@lru_cache(maxsize=2)
def network_axis(axis: int) -> NetworkAxis:
    """One axis, built once (`forget` in the package drops it)."""
    return NetworkAxis(axis)


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


NODES, DIMENSIONS = nn.NODES, 6
