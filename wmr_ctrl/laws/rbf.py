"""Gaussian radial basis on the corners of a cube, with 7 exponentials instead of 64.

S_j(Z) = exp(-|Z - c_j|^2 / eta^2), c_j in {-n, +n}^6.  The squared distance is a sum over the
dimensions, so S_j is a product, and the factors of the far and the near side differ by
exp(-4 n |z| / eta^2).  Everything stays in [0, 1]: nothing overflows, whatever Z is.
"""

from __future__ import annotations

import itertools

import casadi as ca


def corner_centres(dimensions: int, node: float) -> list[tuple[float, ...]]:
    """Centres in the order of `corner_basis`: the first dimension varies slowest, -node first."""
    return list(itertools.product((-node, node), repeat=dimensions))


def corner_basis(z: ca.SX, eta: ca.SX, node: ca.SX) -> ca.SX:
    """S(Z), 2^n x 1, for Z (n x 1), width eta and corner coordinate node (units of Z)."""
    scale = 1 / (eta * eta)
    right = [z[i] >= 0 for i in range(z.numel())]
    size = [ca.if_else(right[i], z[i], -z[i]) for i in range(z.numel())]
    distance = [(item - node) * (item - node) for item in size]
    basis = [ca.exp(-scale * _sum(distance))]
    for flag, item in reversed(list(zip(right, size, strict=True))):
        far = ca.exp(-4 * node * scale * item)
        low, high = ca.if_else(flag, far, 1), ca.if_else(flag, 1, far)
        basis = [value * low for value in basis] + [value * high for value in basis]
    return ca.vertcat(*basis)


def gaussian_basis(z: ca.SX, eta: ca.SX, centres: list[tuple[float, ...]]) -> ca.SX:
    """S(Z) by its definition, one exponential a node: what `corner_basis` must equal."""
    return ca.vertcat(*(ca.exp(-ca.sumsqr(z - ca.DM(centre)) / (eta * eta)) for centre in centres))


def dot(left: ca.SX, right: ca.SX, lanes: int = 8) -> ca.SX:
    """Inner product, summed in independent lanes so that compilers may use vector instructions."""
    partial = [
        _sum([left[j] * right[j] for j in range(lane, left.numel(), lanes)])
        for lane in range(lanes)
    ]
    while len(partial) > 1:
        half = len(partial) // 2
        partial = [partial[i] + partial[i + half] for i in range(half)]
    return partial[0]


def _sum(terms: list[ca.SX]) -> ca.SX:
    total = terms[0]
    for term in terms[1:]:
        total = total + term
    return total
