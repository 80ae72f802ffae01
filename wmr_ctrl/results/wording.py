"""Numbers as sentences and tables show them."""

from __future__ import annotations

from collections.abc import Sequence


def percent(share: float) -> str:
    """A share as "12.3 %": three digits, never as a power of ten from 1 % on."""
    return f"{float(f'{100 * share:.3g}'):g} %"


def speeds(pair: Sequence[float]) -> str:
    """Speeds of both axes as "0.98 m/s, 1.4 rad/s"."""
    return f"{pair[0]:.3g} m/s, {pair[1]:.3g} rad/s"
