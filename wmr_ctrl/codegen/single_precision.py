"""Single-precision packages: C text, the guard's margin, and tested control periods.

A stand-alone package is written for ``wmr_real``, which is double or float.
"""

import math
import re
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from wmr_ctrl.world.model.system import System

from .dialect import SCALAR, Dialect

MARGIN = 2.0**-15
"""The guard's limits are lowered by this share of theirs: 512 times the rounding of a float, as
the graph's own margin is 512 times that of a double."""

LARGEST_SINGLE = 1e6
"""Largest size of an input; in double precision it is `signals.LARGEST`."""

LIMITS = ("limits.v_u1", "filter.wheel_speed")
SIDES = {"limits.v_max": 1.0, "limits.v_min": -1.0}
"""Parameters that are lowered; the signs of limits of one direction."""

PERIODS = {
    ("mb", False): (1e-3,),
    ("nn", False): (1e-3, 1e-2),
    ("prox", False): (1e-3, 1e-2),
    ("mb", True): (1e-3, 1e-2),
    ("nn", True): (1e-3, 1e-2),
    ("prox", True): (1e-3, 1e-2),
}
"""Control periods [s] at which a law, guarded or not, kept the limit in simulation wherever double
precision did; the tests of the boards repeat it."""

BAND_MARGIN = 2.0**-12
"""Margin of the command filter's band: its forecasts are sums over up to 128 commands, each with
three roundings of at most four times the limit, and its tables are rounded, too."""


def with_margin(system: System, margin: float = MARGIN) -> System:
    """The law with its limits' values lowered by ``margin``, a share of the larger limit if
    directions differ.

    A limit that leaves no room beyond a push stays: only 0 is sent then, whatever is rounded.
    """
    known = {item.signal.name: np.array(item.value) for item in system.params}
    lowered = {name: (1 - margin) * known[name] for name in LIMITS if name in known}
    if "limits.v_max" in known:
        push = known.get("filter.d", known.get("filter.delta", 0.0))
        sides = {name: way * known[name] for name, way in SIDES.items()}
        less = margin * np.maximum(*sides.values())
        for name, side in sides.items():
            lowered[name] = SIDES[name] * np.maximum(side - less, np.minimum(side, push))
    values = {name: tuple(pair.tolist()) for name, pair in {**known, **lowered}.items()}
    params = (replace(item, value=values[item.signal.name]) for item in system.params)
    return replace(system, params=tuple(params))


LARGEST_CONSTANT = 1e18
"""Larger finite constants are lowered to this in single precision: their squares must be finite."""

_CALL = re.compile(r"\bwmr_([a-z0-9]+)\(")
_OWN = frozenset({"min", "max", "sign", "expm1"})
"""Functions that every package has of its own: small C libraries lack expm1f."""
_NAMES = {"abs": "fabs"}
"""Deviating names of the C library."""


class SingleDialect(Dialect):
    """Literals and functions of single precision."""

    def number(self, value: float) -> str:
        """A constant with float's suffix."""
        if not math.isfinite(value):
            return super().number(value)
        lowered = math.copysign(min(abs(value), LARGEST_CONSTANT), value)
        text = f"{lowered!r}f"
        return f"({text})" if text.startswith("-") else text

    def as_real(self, truth: str) -> str:
        """A truth value as 1 or 0, without a warning that a float may not hold an integer."""
        return f"({self.real}){truth}"


def package_dialect(float32: bool) -> Dialect:
    """The dialect of a package in double or single precision.

    Single precision has float literals and the C library's functions, ``expf(`` for ``wmr_exp(``,
    except those of _OWN.
    """
    if not float32:
        return replace(SCALAR, real="wmr_real", exp_batch=0, packs_stores=False)

    def called(found: re.Match[str]) -> str:
        name = found[1]
        return found[0] if name in _OWN else f"{_NAMES.get(name, name)}f("

    patterns = {
        op: re.sub(r"\b(\d\.\d)\b", r"\1f", _CALL.sub(called, pattern))
        for op, pattern in SCALAR.patterns.items()
    }
    return SingleDialect("", "wmr_real", "int", MappingProxyType(patterns), lanes=False)
