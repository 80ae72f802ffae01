"""A monitor follows every law: its diagnostics come last, and dbar is a parameter with units."""

import numpy as np
import pytest

from tests.tables import changes
from wmr_ctrl.api import compile_law
from wmr_ctrl.control.controller import law_graph, watched_controller
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.signals import GUARD_DIAGNOSTICS
from wmr_ctrl.world.scenario import load_scenario

every_law = pytest.mark.parametrize("law", tuple(LAWS))
DRIVES = {
    "ideal": {},
    "limited": {"actuator.tau_max": 6.5},
    "slow": changes("actuator.lag = 0.02; actuator.delay = 0.004"),
}
SHORT = changes("""
    clock.duration = 3.0
    changes = [{t = 1.0, m = 65.0, I = 7.0, mu = 0.15}]
""")


def scenario_of(drive="ideal", **changed):
    return load_scenario("paper-simulation", {**SHORT, **DRIVES[drive], **changed})


def diagnostics(system):
    """Signals, and values at the start."""
    at_start = system.function("d", [system.d])(np.zeros(system.u.numel()), system.x0, system.p0)
    return [item.signal for item in system.diagnostics], at_start.full().ravel().tolist()


@every_law
@pytest.mark.slow_but("mb")
def test_the_monitor_comes_last(law):
    """State and diagnostics: first the law's own, unchanged; then tau_applied, then the
    monitor's.
    """
    scenario = scenario_of()
    bare, watched = law_graph(settle(scenario, law)), watched_controller(settle(scenario, law))
    own, further = len(bare.state), [item.signal.name for item in watched.state]

    assert diagnostics(watched)[0] == [*diagnostics(bare)[0], *GUARD_DIAGNOSTICS]
    assert further[:own] == [item.signal.name for item in bare.state]
    assert further[own:] == ["tau_applied", "guard_v", "guard_started"]
    assert compile_law(law).state[: bare.x.numel()] == tuple(
        name for item in bare.state for name in item.signal.elements
    )


@every_law
def test_dbar_is_a_parameter_with_its_units(law):
    given = changes("guard.dbar = [12.0, 3.0]")
    listed = watched_controller(settle(scenario_of(**given), law)).params
    params = {item.signal.name: item for item in listed}

    assert params["guard.dbar"].value == (12.0, 3.0)
    assert params["guard.dbar"].signal.units == ("N", "N.m")
