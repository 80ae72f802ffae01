"""Adaptive RBF-network barrier law of the paper.

Source: Eqs. (57), (58), Theorem 2.  Differences from the paper: nodes, width and start weights are
not given and are READ INTO it (64 nodes on the corners of [-1, 1]^6, shared by both axes, width
sqrt 2, zero weights); the regressor A/(v - v_c1), unbounded on R2, is capped; V1/A and q by
cancellation-free forms.  Options that the paper does not have: regressor = "q" gives the network
q = (v - v_c1)/A in (0, 1] instead of its unbounded inverse, barrier = "smooth" (`smooth_barrier`).
Choose it when mass and friction are unknown or change.
"""

import math
from collections.abc import Mapping

import casadi as ca

from wmr_ctrl.core.fields.section import quantity
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.world.model.system import Output, System, ports

from .context import AXES, LawContext
from .law import BarrierChoice, Basis, Law, Traits

NODES = 64
LANES = 8
"""Independent sums of an inner product, for vector instructions."""
WEIGHTS = tuple(
    Signal(f"W_hat{axis + 1}", unit, f"network weights of axis {axis + 1}", NODES)
    for axis, unit in zip(AXES, ("N.s/m", "N.m.s/rad"), strict=True)
)
W_NORM = Signal("W_norm", "N.s/m, N.m.s/rad", "norms of the weights, after the sample's update", 2)


class NetworkGains(BarrierChoice, key="gains.nn"):
    """Gains of the network law, per axis (linear, angular) where there are two."""

    rho1: tuple[float, float] = quantity(
        (1350.0, 21.6), "kg/s, kg.m2/s", "gain on V1/A, Eq. (57)", above=0.0
    )
    Gamma: tuple[float, float] = quantity(
        (20000.0, 800.0), "1", "adaptation gain, Eq. (58)", minimum=0.0
    )
    sigma: tuple[float, float] = quantity(
        (1e-4, 1e-4), "1/s", "leak of the weights, Eq. (58)", minimum=0.0
    )
    eta: float = quantity(
        math.sqrt(2.0), "1", "width of the Gaussians (read into the paper)", above=0.0
    )
    node: float = quantity(
        1.0, "1", "corner coordinate of the nodes (read into the paper)", above=0.0
    )
    ratio_cap: float = quantity(1e3, "1", "cap of the regressor A/(v - v_c1) = 1/q", above=0.0)
    integrator: str = quantity(
        "explicit", "1", "Euler step of the weights", options=("explicit", "semi-implicit")
    )
    regressor: str = quantity(
        "ratio", "1", "the barrier's quantity that the network uses", options=("ratio", "q")
    )


def build(context: LawContext) -> System:
    """F = -rho1 V1/A + q (W^ S(Z)), Eq. (57), then the weights' step, Eq. (58)."""
    weights = ports(WEIGHTS)
    basis = corner_basis(regressor(context), context.gain("eta"), context.gain("node"))
    network = ca.vertcat(*(dot(item.sym, basis) for item in weights))
    force = -context.gain("rho1") * context.per_axis("V1_over_A") + context.per_axis("q") * network
    following = [_adapted(context, i, weights[i].sym, basis) for i in AXES]
    norms = ca.vertcat(*(ca.sqrt(dot(item, item)) for item in following))
    return context.system(
        "adaptive network (NN)", force, weights, ca.vertcat(*following), (Output(W_NORM, norms),)
    )


def regressor(context: LawContext) -> ca.SX:
    """Z = (v_c0', min(A/(v - v_c1), cap), v), 6x1; the ratio is 1/q, or q itself if so chosen."""
    q = context.per_axis("q")
    if context.own(NetworkGains).regressor == "q":
        return ca.vertcat(context.v_c0_dot, q, context.v)
    cap = context.gain("ratio_cap")
    ratio = [ca.if_else(q[i] * cap > 1, 1 / ca.if_else(q[i] * cap > 1, q[i], 1), cap) for i in AXES]
    return ca.vertcat(context.v_c0_dot, *ratio, context.v)


def _adapted(context: LawContext, axis: int, weights: ca.SX, basis: ca.SX) -> ca.SX:
    """Weights after one Euler step of W' = -Gamma (S w + sigma W), w = v - v_c1, Eq. (58)."""
    rate = context.period * context.gain("Gamma")[axis]
    learning, leak = rate * context.barrier[axis].w, rate * context.gain("sigma")[axis]
    if context.own(NetworkGains).integrator == "semi-implicit":
        return (weights - learning * basis) / (1 + leak)
    return (1 - leak) * weights - learning * basis


def corner_basis(z: ca.SX, eta: ca.SX, node: ca.SX) -> ca.SX:
    """S(Z), 2^n x 1, for Z (n x 1), width eta and corner coordinate node (units of Z).

    S_j(Z) = exp(-|Z - c_j|^2/eta^2), c_j in {-node, +node}^n.  The squared distance is a sum over
    the dimensions, so S_j is a product, and the factors of the far and the near side differ by
    exp(-4 node |z|/eta^2): n + 1 exponentials instead of 2^n.  Everything stays in [0, 1]: nothing
    overflows, whatever Z is.
    """
    scale = 1 / (eta * eta)
    right = [z[i] >= 0 for i in range(z.numel())]
    size = [ca.if_else(right[i], z[i], -z[i]) for i in range(z.numel())]
    basis = [ca.exp(-scale * ca.sumsqr(ca.vertcat(*size) - node))]
    for flag, item in reversed(list(zip(right, size, strict=True))):
        far = ca.exp(-4 * node * scale * item)
        low, high = ca.if_else(flag, far, 1), ca.if_else(flag, 1, far)
        basis = [value * low for value in basis] + [value * high for value in basis]
    return ca.vertcat(*basis)


def dot(left: ca.SX, right: ca.SX) -> ca.SX:
    """Inner product, summed in independent lanes so that compilers can use vector instructions."""
    partial = [ca.dot(left[lane::LANES], right[lane::LANES]) for lane in range(LANES)]
    while len(partial) > 1:
        half = len(partial) // 2
        partial = [partial[i] + partial[i + half] for i in range(half)]
    return partial[0]


def rule(basis: Basis) -> Mapping[str, object]:
    """Gains derived from the robot and its path."""
    rho1 = [rho * mass for rho, mass in zip(basis.rho, basis.mass, strict=True)]
    learning = [gain * rho / 4 for gain, rho in zip(rho1, basis.rho, strict=True)]
    return {"rho1": rho1, "Gamma": learning, "regressor": "q"}


TRAITS = Traits(auxiliary=True, barrier=True, theorem=2, estimates=True)
LAW = Law("nn", NetworkGains, build, TRAITS, __doc__, tuned=("rho1", "Gamma"), rule=rule)
