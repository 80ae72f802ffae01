"""Warning: one objection of theory to a run; and texts that several checks share."""

from collections.abc import Callable, Iterable, Mapping

from wmr_ctrl.control.laws.prox import ProxGains, guide
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.references import reference_bounds
from wmr_ctrl.world.scenario import Scenario, override

from .loop import Loop
from .sending import loop_of

SPEEDS = ("v1", "omega")
UNITS = ("m/s", "rad/s")
FORCE_UNITS = ("N", "N m")


def joined(parts: Iterable[str]) -> str:
    """Join texts as in "a", "a and b" or "a, b and c"."""
    *head, last = parts
    return f"{', '.join(head)} and {last}" if head else last


def is_taken(scenario: Scenario, changes: Mapping[str, object], law: str | None) -> bool:
    """True if the scenario with these keys changed is valid for a law, or for any law (None)."""
    try:
        settle(override(scenario, changes), law)
    except ScenarioError:
        return False
    return True


def gains_that_fit(loop: Loop, cured: Callable[[Loop], bool]) -> str:
    """End of a sentence: where to find gains that fit the control period.

    Those of `guide` are named if the loop with them is ``cured`` of the finding.
    """
    tuned = ", as `wmr-ctrl tune` finds them" if loop.setup.control_law.tuned else ""
    if not isinstance(loop.setup.gains, ProxGains):
        return tuned
    period, speed = loop.scenario.clock.control, max(map(abs, reference_bounds(loop.scenario)[:2]))
    fit = guide(period, loop.around.drives.delay, speed, loop.setup.predicted > 0)
    k, rho = (", ".join(f"{value:.3g}" for value in values) for values in (fit.k, fit.rho))
    own = {"gains.prox.rho": f"[{rho}]", "gains.prox.wo": f"{fit.wo:.3g}"}
    gains = {loop.setup.kinematic_key: f"[{k}]", **own}
    changed = override(loop.scenario, gains)
    if not cured(loop_of(settle(changed, loop.law))):
        return tuned
    first, second, third = (f"{key} = {text}" for key, text in gains.items())
    return (
        f": wmr_ctrl.control.laws.prox.guide gives {first}, {second} and {third}, `wmr-ctrl tune` "
        "searches for better ones"
    )
