"""What a scenario states and itself breaks, and a plant step that its friction is too stiff for."""

from __future__ import annotations

from collections.abc import Iterator

from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.checks.warning import Warning
from wmr_ctrl.guard.contradictions import contradictions
from wmr_ctrl.world.friction import phases

COARSE, UNSTABLE = 1.0, 2.785
"""Plant step times slope of the friction: what is coarse for RK4, and what makes it diverge."""


def contradicted(loop: Loop) -> Iterator[Warning]:
    """Yield every stated bound that the scenario breaks, be the guard on or off."""
    for item in contradictions(loop.scenario, loop.setup.bound):
        yield Warning(item.key, item.sentence, "guard, docs/guarantee.md")


def coarse_step(loop: Loop) -> Iterator[Warning]:
    """Yield where a plant step is long for mu m g tanh(v1/v_s) at rest, whose slope is steepest."""
    robot, step = loop.scenario.robot, loop.scenario.clock.plant
    slope = max(phase.mu * robot.g / robot.v_s for phase in phases(loop.scenario))
    if step * slope <= COARSE:
        return
    yield Warning(
        "clock.plant",
        f"clock.plant = {step:g} s is too coarse for the friction: mu g tanh(v1/v_s) changes at up "
        f"to {slope:.4g} 1/s, and the product of both, {step * slope:.3g}, should be at most "
        f"{COARSE:g} (RK4 diverges from {UNSTABLE:g} on). Choose {COARSE / slope:.2g} s or less, "
        "or a larger robot.v_s.",
        "Eq. (4), RK4",
    )
