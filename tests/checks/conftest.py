"""Loops of the paper's scenario with fields overridden; numbers come from the paper's audit."""

import pytest

from tests.checks.asking import told_of
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.checks.sending import loop_of
from wmr_ctrl.world.scenario import load_scenario

NOMINAL = "paper-simulation-nominal"


@pytest.fixture(scope="session")
def loop():
    def build(law, overrides=None, scenario=NOMINAL):
        return loop_of(settle(load_scenario(scenario, overrides), law))

    return build


@pytest.fixture(scope="session")
def told():
    """Return a function that gives the warnings about a setup, or about one key."""

    def ask(law, overrides=None, scenario=NOMINAL, key=""):
        return told_of(settle(load_scenario(scenario, overrides), law), key)

    return ask
