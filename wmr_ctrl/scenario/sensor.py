"""How pose and velocity are measured."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from wmr_ctrl.fields.section import Section, quantity


@dataclass(frozen=True)
class Sensor(Section):
    """Measurement of pose and velocity; the defaults are a perfect sensor.

    Between two measured poses the pose is predicted from the velocity; each measured pose
    corrects the prediction by the share ``correction`` of the difference.
    """

    KEY: ClassVar[str] = "sensor"

    pose_period: float = quantity(
        0.0, unit="s", doc="time between two poses; 0: one every control period", minimum=0
    )
    pose_noise: float = quantity(
        0.0, unit="m", doc="half-width of the uniform error in x and y; theta is exact", minimum=0
    )
    velocity_noise: tuple[float, float] = quantity(
        (0.0, 0.0),
        unit="m/s, rad/s",
        doc="half-widths of the uniform error in v1, omega",
        minimum=0,
    )
    correction: float = quantity(
        1.0, unit="1", doc="share of the pose's difference that is corrected", above=0, maximum=1
    )

    @property
    def perfect(self) -> bool:
        """Whether the laws see the true pose at every sample (velocity noise apart)."""
        return self.pose_period == 0 and self.pose_noise == 0 and self.correction == 1
