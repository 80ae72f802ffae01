"""Warning: one objection of theory to a run; and texts that several checks share."""

from collections.abc import Iterable, Mapping

from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario import Scenario, override

from .loop import Loop

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


def as_tuned(loop: Loop) -> str:
    """End of a sentence: where to find suitable gains; empty for a law that is not tuned."""
    return ", as `wmr-ctrl tune` finds them" if loop.setup.control_law.tuned else ""
