"""Exports that contain only a part of the loop, and the effects that they would lack."""

from wmr_ctrl.core.errors import ArgumentError, ScenarioError
from wmr_ctrl.core.signals import TORQUE_NOISE
from wmr_ctrl.core.symbolic import ca
from wmr_ctrl.world.effect import Effect, EffectRole
from wmr_ctrl.world.scenario import Scenario
from wmr_ctrl.world.standstill import STANDSTILL

from .setup import Setup


def check_plain_loop(setup: Setup, holder: str) -> None:
    """Raise ArgumentError for effects that a loop of reference, controller and plant would lack.

    These are all active effects except random numbers at the plant's inputs, which come from
    outside. ``holder``: name of the export, such as "the Simulink kit".
    """
    scenario = setup.scenario
    if (scenario.filter if scenario.takes_velocity else scenario.guard).changing:
        raise ArgumentError(
            f"{holder} holds only reference, controller and plant, and nothing that sends limits. "
            "Leave out guard.changing and filter.changing, or export the law alone."
        )
    acting = [item for item in setup.effects if item.active(scenario)]
    missed = [item.title for item in acting if not _is_noise(item, scenario)]
    if missed:
        raise ArgumentError(
            f"{holder} holds only reference, controller and plant, but the scenario "
            f"{scenario.name} also has: {', '.join(missed)}. Export the closed-loop FMU, which "
            "includes everything, or remove this from the scenario."
        )


def check_outside_plant(setup: Setup) -> None:
    """Raise ArgumentError for options that only the loop's own plant supports."""
    if STANDSTILL in setup.effects:
        raise ArgumentError(
            f"base.rest = {setup.scenario.base.rest:g}: a plant outside of the loop has no brake "
            "that could hold it. Leave it out, or run the plant ode."
        )


def _is_noise(effect: Effect, scenario: Scenario) -> bool:
    """True for an effect that is only random numbers at the wheels: it vanishes if they are 0."""
    if effect.role is not EffectRole.DISTURBANCE:
        return False
    system = effect.system(scenario)
    at_wheels = all(item.signal in TORQUE_NOISE for item in system.outputs)
    quiet = ca.substitute(system.y, system.w, ca.SX.zeros(system.w.shape))
    return at_wheels and not system.state and bool(system.draws) and quiet.is_zero()


def check_takes_torques(scenario: Scenario, holder: str) -> None:
    """Raise ScenarioError for a base that takes velocities, which ``holder`` does not support."""
    if scenario.takes_velocity:
        off = "" if scenario.filter.kind == "none" else ' and filter.kind = "none"'
        raise ScenarioError(
            f'base.kind = "velocity": {holder} only for robots that take wheel torques. Runs, '
            "studies, `check` and the closed-loop FMU support the base's speed loop. Use one of "
            f'these, or set base.kind = "torque"{off}.'
        )
