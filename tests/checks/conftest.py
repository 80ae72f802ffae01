"""Loops of the paper's scenario with fields overridden; numbers come from the paper's audit."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from tests.checks.asking import told_of
from wmr_ctrl.control.setup import settle
from wmr_ctrl.results.verdicts import Warning
from wmr_ctrl.theory.checks.loop import Loop
from wmr_ctrl.theory.checks.sending import loop_of
from wmr_ctrl.world.scenario import load_scenario

NOMINAL = "paper-simulation-nominal"


@pytest.fixture(scope="session")
def loop() -> Callable[..., Loop]:
    def build(law: str, overrides: dict | None = None, scenario: str = NOMINAL) -> Loop:
        return loop_of(settle(load_scenario(scenario, overrides), law))

    return build


@pytest.fixture(scope="session")
def told() -> Callable[..., list[Warning]]:
    """The warnings, optionally those of one key."""

    def ask(law: str, overrides: dict | None = None, scenario: str = NOMINAL, key: str = ""):
        return told_of(settle(load_scenario(scenario, overrides), law), key)

    return ask
