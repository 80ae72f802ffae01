"""What the wheels' drives make of a commanded torque."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from wmr_ctrl.fields.section import Section, quantity


@dataclass(frozen=True)
class Actuator(Section):
    """Torque limit, first-order lag and delay of the drives; the defaults are ideal drives."""

    KEY: ClassVar[str] = "actuator"

    tau_max: float = quantity(
        math.inf, unit="N.m", doc="largest torque of each wheel; inf: none", above=0, infinite=True
    )
    lag: float = quantity(0.0, unit="s", doc="time constant of the torque's lag", minimum=0)
    delay: float = quantity(
        0.0, unit="s", doc="delay of the torque, a multiple of clock.plant", minimum=0, maximum=10
    )

    @property
    def ideal(self) -> bool:
        """Whether the torque acts at once (it may still be limited)."""
        return self.lag == 0 and self.delay == 0
