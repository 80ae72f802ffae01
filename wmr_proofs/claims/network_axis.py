"""One axis of the adaptive network's law with its inner quantities free, and charts of these."""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import casadi as ca

from wmr_ctrl.control.laws import nn
from wmr_ctrl.control.laws.context import LawContext
from wmr_ctrl.world.model.dynamics import acceleration
from wmr_proofs import paper_functions as analysis
from wmr_proofs.statement import Named, Statement, column, stacked, symbols

from .common import LawGraph


class NetworkAxis(Named):
    """The network law's graph on one axis, with the barrier's quotients, w and S free.

    ``free``: V1/A, q, w, S, then A, V1, v_c0', F1, the true mass and the best weights W*, and
    ``inner`` their expressions in the graph; S(Z) is ``basis``, W* ``best``, W^ ``weights``, W~ =
    W^ - W* ``error``.  ``weight_rate`` is (W^(k+1) - W^(k))/T, which the explicit step integrates;
    ``residual`` eps2 of Eq. (59), taken as its definition: what W*'S misses of the target.  Under
    the law's force ``barrier_rate`` is V1i' of Eq. (28), ``rate`` V3i', differentiated from (62).
    """

    def __init__(self, axis: int) -> None:
        self.axis, self.law = axis, LawGraph("nn")
        law, t = self.law, self.law.symbols
        names = symbols("quotient q w A V cdot friction mass")
        self.free = f = names | column("S", NODES) | column("best", NODES)
        self.symbols = t | f
        self.basis, self.best = (stacked(f, name, NODES) for name in ("S", "best"))
        self.weights = ca.vertcat(*(t[f"W_hat{axis + 1}[{j + 1}]"] for j in range(NODES)))
        self.error = self.weights - self.best
        self.inner = self._inner(law.context)
        rows = slice(axis * NODES, (axis + 1) * NODES)
        self.weight_rate = (law.system.update[rows] - self.weights) / t["clock.control"]
        target = analysis.network_target(f.mass, f.cdot, f.A / f.w, f.friction)
        self.residual = ca.dot(self.best, self.basis) - target
        v_dot = acceleration(f.mass, law.force[axis], f.friction)  # of the true robot, Eq. (4)
        self.barrier_rate = f.A * v_dot - f.w * f.cdot
        value, weights = ca.SX.sym("V1i"), ca.SX.sym("W", NODES)
        total = analysis.network_lyapunov(value, f.mass, self.gain("Gamma"), weights)
        state = ca.vertcat(value, weights)
        rate = ca.jtimes(total, state, ca.vertcat(self.barrier_rate, self.weight_rate))
        self.rate = ca.substitute(rate, state, ca.vertcat(f.V, self.error))

    def _inner(self, context: LawContext) -> dict[str, ca.SX]:
        basis = nn.corner_basis(nn.regressor(context), context.gain("eta"), context.gain("node"))
        found = {f"S{j + 1}": self.law.own(basis[j]) for j in range(NODES)}
        return self.law.parts(self.axis, "quotient q w") | found

    def gain(self, name: str) -> ca.SX:
        """A gain of this axis."""
        return self.law[f"gains.nn.{name}[{self.axis + 1}]"]

    def statement(self, *goals: Any) -> Statement:
        """Goals with the graph's inner quantities free."""
        return Statement(self, goals, (), self.inner)


@lru_cache(maxsize=2)
def network_axis(axis: int) -> NetworkAxis:
    """One axis, built once (`forget` in the package drops it)."""
    return NetworkAxis(axis)


def free_chart(n: Mapping[str, Any]) -> dict[str, Any]:
    """V1/A and q from A, V1 and w."""
    return {"quotient": n["V"] / n["A"], "q": n["w"] / n["A"], **{k: n[k] for k in ("A", "V", "w")}}


def vanishing_chart(n: Mapping[str, Any]) -> dict[str, Any]:
    """A = 0, which happens only with V1 = 0 and w = 0; the compiled quotients are then limits."""
    return {**dict.fromkeys(("A", "V", "w"), 0 * n["quotient"]), **n}


def residual_chart(n: Mapping[str, Any]) -> dict[str, Any]:
    """F1 chosen such that eps2 = w - n with a free n; V1 = w^2/2 + p, W* = W^ - E."""
    w = n["y"]
    value, nodes = w**2 / 2 + n["p"], range(1, NODES + 1)
    best = {f"best{j}": n[f"X{j}"] - n[f"E{j}"] for j in nodes}
    weights = {f"W_hat1[{j}]": n[f"X{j}"] for j in nodes}
    learnt = sum((best[f"best{j}"] * n[f"S{j}"] for j in nodes), 0 * w)
    friction = (learnt - n["mass"] * n["cdot"] - (w - n["n"])) * w / n["A"]
    found = {"V": value, "w": w, "quotient": value / n["A"], "q": w / n["A"], "friction": friction}
    kept = ["A", "mass", "cdot", *(f"S{j}" for j in nodes)]
    return {**found, **best, **weights, **{name: n[name] for name in kept}}


def decay_chart(n: Mapping[str, Any]) -> dict[str, Any]:
    """Both rates of (86) exceed rho2: rho1 = 1 + M (rho2 + a), sigma Gamma = rho2 + b."""
    gains = {"Gamma": n["gamma"], "rho1": 1 + n["mass"] * (n["rho2"] + n["a"])}
    gains["sigma"] = (n["rho2"] + n["b"]) / n["gamma"]
    named = {f"gains.nn.{name}[1]": value for name, value in gains.items()}
    return {**residual_chart(n), "rho2": n["rho2"], **named}


NODES, DIMENSIONS = nn.NODES, 6
