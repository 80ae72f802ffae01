"""Windows of the figures that are drawn from a run, and what counts as tracked."""

from __future__ import annotations

from wmr_ctrl.fields.section import Section, quantity


class Metrics(Section, key="metrics"):
    """Where a run is split into before and after, where the RMS of the torque begins, tolerance.

    The default tolerance is a tenth of the paper's robot's track, 0.5 m: what a wheel's width or a
    doorway leaves.  It is ten times what a good law leaves, and less than a law that lost its
    reference leaves.
    """

    split: float | None = quantity(
        None, unit="s", doc="split into before and after; left out: half the duration", above=0
    )
    rms_from: float = quantity(
        2.0, unit="s", doc="the torque's RMS is taken from here on", minimum=0
    )
    tolerance: float = quantity(
        0.05,
        unit="m",
        doc="RMS of the position error, in the drive and at the end, that counts as tracked",
        above=0,
    )
