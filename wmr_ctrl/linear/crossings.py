"""Where a loop's frequency response crosses the unit circle and the negative real axis.

Crossings are bracketed on a grid and then polished.  python-control finds them as roots of
polynomials, which for sampled loops of this size lose all their digits.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import control as ct
import numpy as np
from scipy.optimize import brentq

from wmr_ctrl.linear.numbers import Floats


@dataclass(frozen=True)
class Crossings:
    """Gain factors [ratio], phases [degrees] and delays [s] that bring the loop to its limit."""

    gains: Floats
    phases: Floats
    delays: Floats


def crossings(loop: ct.StateSpace, frequencies: Floats) -> Crossings:
    """All crossings of a single loop L within the range of ``frequencies`` [rad/s]."""
    response = _response(loop)
    values = np.asarray(response(frequencies))
    unit = _roots(lambda w: math.log(abs(response(w))), frequencies, np.log(np.abs(values)))
    real = _roots(lambda w: response(w).imag, frequencies, values.imag)
    ahead = np.array([np.angle(-response(w)) for w in unit])
    found = np.array([response(w).real for w in real] + _at_nyquist(loop))
    return Crossings(
        -1 / found[found < 0],
        np.degrees(ahead),
        np.array([a % (2 * math.pi) / w for a, w in zip(ahead, unit, strict=True)]),
    )


def _response(loop: ct.StateSpace) -> Callable[[float | Floats], Any]:
    def at(w: float | Floats) -> Any:
        points = np.exp(1j * w * loop.dt) if loop.dt else 1j * w
        return np.squeeze(loop(points))[()]

    return at


def _roots(of: Callable[[float], float], grid: Floats, values: Floats) -> list[float]:
    signs = np.signbit(values)
    pairs = [pair for k, pair in enumerate(pairwise(grid)) if signs[k] != signs[k + 1]]
    return [float(brentq(of, low, high, rtol=1e-12)) for low, high in pairs]


def _at_nyquist(loop: ct.StateSpace) -> list[float]:
    """A sampled loop is real at z = -1, where its response ends."""
    return [complex(np.squeeze(loop(-1.0 + 0j))).real] if loop.dt else []
