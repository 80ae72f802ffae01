"""Figures beyond the paper's: what its measure hides, and where its guarantee ends."""

from __future__ import annotations

from wmr_ctrl.campaign import Campaign
from wmr_ctrl.report.drawing import Drawing
from wmr_ctrl.report.extras.barrier import barrier_drawing
from wmr_ctrl.report.extras.limits import limits_drawing
from wmr_ctrl.report.extras.measure import measure_drawing
from wmr_ctrl.report.extras.stress import stress_drawing
from wmr_ctrl.report.extras.switch import switch_drawing
from wmr_ctrl.report.extras.torque import torque_drawing

__all__ = ["HIDDEN", "STRESS", "extra_figures"]

HIDDEN = ("measure", "switch", "lyapunov_noise_free", "torque")
"""Names of the figures on what the paper's measure hides, in the report's order."""

STRESS = ("limits_all_seeds", "stress_velocities")
"""Names of the figures on where the guarantee ends."""


def extra_figures(campaign: Campaign) -> tuple[Drawing, ...]:
    """Every figure of :data:`HIDDEN` and :data:`STRESS`, in their order."""
    return (
        measure_drawing(campaign),
        switch_drawing(campaign),
        barrier_drawing(campaign),
        torque_drawing(campaign),
        limits_drawing(campaign),
        stress_drawing(campaign),
    )
