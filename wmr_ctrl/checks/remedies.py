"""Remedies that several checks end with."""

from __future__ import annotations

from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.laws.prox import ProxGains, guide
from wmr_ctrl.world.references import reference_bounds


def gains_that_fit(loop: Loop) -> str:
    """Where to get gains that fit the control period, as the end of a sentence."""
    if not isinstance(loop.setup.gains, ProxGains):
        return ", as `wmr-ctrl tune` finds them" if loop.setup.control_law.tuned else ""
    period, speed = loop.scenario.clock.control, max(map(abs, reference_bounds(loop.scenario)[:2]))
    fit = guide(period, loop.around.drives.delay, speed, loop.setup.predicted > 0)
    k, rho = (", ".join(f"{value:.3g}" for value in values) for values in (fit.k, fit.rho))
    return (
        f": wmr_ctrl.laws.prox.guide gives gains.kinematics.k = [{k}], gains.prox.rho = [{rho}] "
        f"and gains.prox.wo = {fit.wo:.3g}, `wmr-ctrl tune` searches for better ones"
    )
