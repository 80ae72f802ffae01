"""The scalar dialect for a stand-alone package: ``wmr_real``, which is double or float."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from types import MappingProxyType

from wmr_ctrl.codegen.dialect import SCALAR, Dialect

LARGEST = 1e18
"""Larger finite constants are lowered to this in single precision: their squares must be finite."""

_CALL = re.compile(r"\bwmr_(?!min\b|max\b|sign\b)([a-z0-9]+)\(")
_NAMES = {"abs": "fabs"}
"""What the C library calls otherwise."""


class SingleDialect(Dialect):
    """Literals and functions of single precision."""

    def number(self, value: float) -> str:
        """A constant with the suffix of float."""
        if not math.isfinite(value):
            return super().number(value)
        lowered = math.copysign(min(abs(value), LARGEST), value)
        text = f"{lowered!r}f"
        return f"({text})" if text.startswith("-") else text


def package_dialect(float32: bool) -> Dialect:
    """The dialect of a package in double or single precision."""
    if not float32:
        return replace(SCALAR, real="wmr_real", together=0, fours=False)
    patterns = {op: _single(text) for op, text in SCALAR.patterns.items()}
    return SingleDialect("", "wmr_real", "int", MappingProxyType(patterns), lanes=False)


def _single(pattern: str) -> str:
    """A pattern with the C library's functions and literals of float: ``wmr_exp(`` as ``expf(``."""
    called = _CALL.sub(lambda call: f"{_NAMES.get(call[1], call[1])}f(", pattern)
    return re.sub(r"\b(\d\.\d)\b", r"\1f", called)
