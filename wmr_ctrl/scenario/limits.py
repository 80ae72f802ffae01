"""Velocity limits of the robot and of the barrier function."""

from __future__ import annotations

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.fields.section import Section, quantity

UNITS = ("m/s", "rad/s")


class Limits(Section, key="limits"):
    """Velocity limits v_u1 and barrier thresholds v_u2 (linear, angular), Eqs. (10)-(20)."""

    v_u1: tuple[float, float] = quantity(
        (1.0, 1.5), unit="m/s, rad/s", doc="limits of |v1| and |omega|", above=0
    )
    v_u2: tuple[float, float] = quantity(
        (0.8, 1.3), unit="m/s, rad/s", doc="thresholds from which the barrier acts", above=0
    )
    clip: float = quantity(
        1e-6, unit="m/s, rad/s", doc="barrier terms see |v| clipped to v_u1 - clip", above=0
    )

    def relate(self) -> None:
        """Each axis needs v_u2 < v_u1 and clip < v_u1 - v_u2."""
        for axis, (high, low, unit) in enumerate(zip(self.v_u1, self.v_u2, UNITS, strict=True), 1):
            if not low < high:
                raise ScenarioError(
                    f"limits.v_u2[{axis}] = {low!r} must be below limits.v_u1[{axis}] = {high!r} "
                    f"{unit}: the barrier acts between the two. Lower v_u2 or raise v_u1."
                )
            if not self.clip < high - low:
                raise ScenarioError(
                    f"limits.clip = {self.clip!r} must be below v_u1[{axis}] - v_u2[{axis}] = "
                    f"{high - low:g} {unit}, or the barrier never acts. The default is 1e-06."
                )
