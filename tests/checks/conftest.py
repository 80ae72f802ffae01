"""Loops of the paper's scenario with fields overridden; numbers come from the paper's audit."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from wmr_ctrl.checks import Warning, warnings_for
from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.control.setup import settle
from wmr_ctrl.scenario import load_scenario

NOMINAL = "paper-simulation-nominal"


@pytest.fixture(scope="session")
def loop() -> Callable[..., Loop]:
    def build(law: str, overrides: dict | None = None, scenario: str = NOMINAL) -> Loop:
        return Loop(settle(load_scenario(scenario, overrides), law))

    return build


@pytest.fixture(scope="session")
def told() -> Callable[..., list[Warning]]:
    """The warnings, optionally those of one key."""

    def ask(law: str, overrides: dict | None = None, scenario: str = NOMINAL, key: str = ""):
        found = warnings_for(settle(load_scenario(scenario, overrides), law))
        return [warning for warning in found if key in ("", warning.key)]

    return ask
