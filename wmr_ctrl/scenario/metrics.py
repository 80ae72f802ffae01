"""Windows of the figures that are drawn from a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from wmr_ctrl.fields.section import Section, quantity


@dataclass(frozen=True, kw_only=True)
class Metrics(Section):
    """Where a run is split into before and after, and where the RMS of the torque begins."""

    KEY: ClassVar[str] = "metrics"

    split: float | None = quantity(
        None, unit="s", doc="split into before and after; left out: half the duration", above=0
    )
    rms_from: float = quantity(
        2.0, unit="s", doc="the torque's RMS is taken from here on", minimum=0
    )
