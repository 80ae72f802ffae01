"""Reader of a caller's scenario (a preset, a file or a Scenario, with overrides) and law."""

from collections.abc import Mapping
from pathlib import Path
from typing import TypeAlias

from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.world.scenario import Scenario, load_scenario, override
from wmr_ctrl.world.scenario.toml_io import naming_file

from .default_law import DefaultLaw as DefaultLaw
from .default_law import default_law as default_law
from .default_law import judges_gains as judges_gains
from .default_law import law_of as law_of
from .setup import check_name, check_scenario

Overrides: TypeAlias = Mapping[str, object]
"""Values of a scenario's fields by key path, such as ``{"clock.control": 0.02}``."""


@checks_arguments
def scenario_of(
    given: str | Path | Scenario,
    overrides: Overrides | None = None,
    guard: bool | None = None,
) -> Scenario:
    """A checked scenario from a preset's name, a TOML file or a Scenario, with fields overridden.

    ``overrides`` maps key paths to values (``{"clock.control": 0.02}``); ``guard`` True or False
    replaces guard.enabled.  Raises ScenarioError or UnknownNameError, each naming the key.

    >>> scenario_of("far-start", {"robot.mu": 0.1}).robot.mu
    0.1
    """
    changed = {**(overrides or {}), **({} if guard is None else {"guard.enabled": guard})}
    if isinstance(given, str):
        check_name(given)
    loaded = (
        override(given, changed) if isinstance(given, Scenario) else load_scenario(given, changed)
    )
    with naming_file(given, changed):
        check_scenario(loaded)
    return loaded
