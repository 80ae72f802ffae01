"""Torque on the wheels that no law commands: random, or as adverse as its size allows."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from wmr_ctrl.fields.section import Section, quantity


@dataclass(frozen=True)
class Disturbance(Section):
    """Gaussian torque on each wheel, drawn once per control period and held over it.

    ``push`` is an adversary's: at every sample it pushes each axis on in the direction in which it
    moves.
    """

    KEY: ClassVar[str] = "disturbance"

    std: float = quantity(
        1.0, unit="N.m", doc="standard deviation of the torque on each wheel", minimum=0
    )
    truncate: float = quantity(
        math.inf,
        unit="1",
        doc="draw again beyond this many std; inf: never",
        above=0,
        infinite=True,
    )
    push: tuple[float, float] = quantity(
        (0.0, 0.0), unit="N, N.m", doc="force that always pushes away from rest", minimum=0
    )
