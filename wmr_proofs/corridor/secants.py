"""Secants: linear maps that enclose a graph over boxes, with remainders, at many places.

Near a change of friction's sign, gradients at a point say little about a box.  An affine form of
the graph over the box (`wmr_proofs.corridor.affine`) is used instead: f(x) = c + S (x - x_c) + off,
with |off| <= r on the box.  With ``off`` known at the undisturbed point x_0, f(x_0 + d) differs
from f(x_0) + S d by at most r plus the size of that ``off``.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from wmr_ctrl.theory.checks.error_coordinates import Floats

from .affine import AffineGraph
from .loop import UP
from .midradius import SMALLEST, MidRadius
from .motion import MovingCurve

LEAST = 1e-9
"""Half-width of a box that would have less, so that there is a slope."""


@dataclass(frozen=True)
class Secants:
    """Secants over C boxes: ``slopes`` (C, outputs, n) for deviations up to ``wide`` (C, n).

    ``left`` (C, outputs): sizes of their remainders.
    """

    slopes: MidRadius
    left: Floats
    wide: Floats


class SecantCurve:
    """The affine forms of a graph of variables and numbers."""

    def __init__(self, curve: MovingCurve) -> None:
        """Read the graph."""
        self.count = curve.by.numel()
        self._graph = AffineGraph(ca.vertcat(curve.by, curve.numbers), curve.output)

    def over(
        self, by: MidRadius, numbers: MidRadius, wide: Floats, points: Floats, values: Floats
    ) -> Secants:
        """Secants over boxes ``wide`` (C, n) about spans ``by`` (C, n), for the motion's
        ``numbers`` (C, m).

        ``points`` (C, P, n): the nominal trajectory; ``values`` (C, P, outputs): the graph there.
        """
        n = self.count
        wide = wide + LEAST * (wide > 0)
        center = np.hstack([by.middle, numbers.middle])
        parts = (by.radius + wide, by.middle), (numbers.radius, numbers.middle)
        radius = np.hstack([np.broadcast_to(one, like.shape) for one, like in parts])
        forms = self._graph(center, radius)
        L = np.abs(forms.L)
        slopes = forms.L[:, :, :n] / (radius + (radius == 0))[:, None, :n]
        left = forms.r + 1e-15 * (forms.size + L[:, :, :n].sum(axis=2)) + L[:, :, n:].sum(axis=2)
        middle = forms.c
        away = points - by.middle[:, None]
        linear = np.einsum("cij,cpj->cpi", slopes, away)
        size = np.einsum("cij,cpj->cpi", np.abs(slopes), np.abs(away)) + np.abs(middle)[:, None]
        off = np.abs(values - middle[:, None] - linear) + 1e-13 * (size + np.abs(values))
        return Secants(
            MidRadius(slopes, np.zeros_like(slopes)), (left + off.max(axis=1)) * UP + SMALLEST, wide
        )
