"""A sudden change of the robot's parameters."""

from __future__ import annotations

from wmr_ctrl.fields.section import REQUIRED, Section, quantity


class Change(Section, key="changes"):
    """New parameters from the first plant step that starts at or after ``t``; others stay."""

    t: float = quantity(REQUIRED, unit="s", doc="time of the change", minimum=0)
    m: float | None = quantity(None, unit="kg", doc="mass from then on", above=0)
    I: float | None = quantity(None, unit="kg.m2", doc="inertia from then on", above=0)
    mu: float | None = quantity(None, unit="1", doc="friction from then on", minimum=0)

    def values(self) -> dict[str, float]:
        """What changes, by the robot's field."""
        given = {"m": self.m, "I": self.I, "mu": self.mu}
        return {key: value for key, value in given.items() if value is not None}
