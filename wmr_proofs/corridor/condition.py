"""Conditions under which the loop equals the certified model."""

from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca

AXES = ("linear", "angular")


@dataclass(frozen=True)
class Condition:
    """A bound |value| <= most under which the loop equals the certified model.

    ``inner``: the certificate chose its size, which is not the size of a limit.  ``measured``: axis
    whose measurement error of the velocity a first sample adds to the value.
    """

    name: str
    value: ca.SX
    most: ca.SX
    measured: int | None = None
    inner: bool = False


Asked = Callable[[ca.SX, ca.SX], list[Condition]]
"""Conditions on the force that the law asks for (2) and the velocity that is measured (2)."""
