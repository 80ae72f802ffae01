"""The guard behind a controller that has none: somebody else's, or ours exported without it."""

import re

import numpy as np
import pytest

from tests.export.fmi.test_fmi_equality import assert_same
from wmr_ctrl.api import simulate
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ArgumentError, ScenarioError
from wmr_ctrl.export.cosim import cosimulate
from wmr_ctrl.export.cosim.run import CosimSetup
from wmr_ctrl.results import summary
from wmr_ctrl.world.scenario import load_scenario, override

SAFE = override(
    load_scenario("safe-simulation"),
    {"clock.duration": 2.0, "initial.velocity": [0.9, -1.3], "guard.alpha": 5.0},
)
BARE = override(SAFE, {"guard.enabled": False})
EAGER = '''
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class Eager(Fmi2Slave):
    """Full thrust to the right, told in N and N m, for a while."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.speed = self.first = self.second = 0.0
        self.register_variable(Real("speed", causality=Fmi2Causality.input))
        for name in ("first", "second"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))

    def do_step(self, t, h):
        self.first, self.second = (120.0, 15.0) if t < 1.0 else (0.0, 0.0)
        return True
'''
MAP = """
[controller.inputs]
speed = { terms = { v1 = 1.0 }, unit = "m/s" }
[controller.outputs]
"force[1]" = { terms = { first = 1.0 }, unit = "N" }
"force[2]" = { terms = { second = 1.0 }, unit = "N.m" }
"""


@pytest.fixture
def eager(foreign, mapped):
    return {"controller": foreign("Eager", EAGER), "map_file": mapped(MAP)}


def test_the_guard_keeps_a_foreign_controller_within(eager):
    free, run = (
        cosimulate(case, **eager, master="jacobi", delay_known=True) for case in (BARE, SAFE)
    )
    assert run.monitor.violations == 0 < free.monitor.violations
    assert (run.guard, free.guard) == (True, False)
    assert 0 < summary(run)["guard_share"][0] <= np.mean(run["t"] < 1.1)
    assert (run["feasible"] == 1).all()
    assert np.isfinite(run["d_least"]).all()
    assert np.isnan(free["d_least"]).all()
    quiet = ~run["clip_active"].any(axis=1) & (run["t"] < 1.0) & (run["t"] > 0)
    # 120 N and 15 N m at such wheels
    for name, torque in (("tau_right", 9.0), ("tau_left", 3.0)):
        assert free[name][5] == pytest.approx(torque, rel=1e-12)
        assert np.abs(run[name][quiet] - torque).max(initial=0.0) < 1e-11


@pytest.mark.parametrize(
    "law, version, master", [("pid", 2, None), ("nn", 3, None), ("mb", 2, "jacobi")]
)
@pytest.mark.slow
def test_a_law_of_ours_guarded_from_outside_is_the_guarded_run(exported, law, version, master):
    """Under the Jacobi master it equals the run with the guard in the controller."""
    given = {"seed": 4, "fmi": version} | ({"master": master} if master else {})
    run = cosimulate(SAFE, controller=exported(law, version, BARE), **given)
    guarded = cosimulate(SAFE, law, **given) if master else simulate(SAFE, law, seed=4)

    assert guarded["clip_active"].any()
    assert_same(run, guarded)
    assert summary(run)["guard_share"] == summary(guarded)["guard_share"]
    assert run.provenance["fmu_guard"].startswith("wmr_guard (")
    with pytest.raises(ArgumentError, match=r"prox relies on the torque .* with the guard"):
        cosimulate(SAFE, controller=exported("prox", 2, BARE))


def test_a_guard_that_cannot_hold_is_refused_as_in_a_run(eager):
    weak = override(SAFE, {"actuator.tau_max": 0.1})
    with pytest.raises(ScenarioError) as native:
        simulate(weak, "mb")
    with pytest.raises(ScenarioError, match=re.escape(str(native.value))):
        cosimulate(weak, **eager)


@pytest.mark.parametrize("foreign, bare", [(False, False), (True, False), (False, True)])
def test_a_guard_steps_by_itself_behind_a_controller_that_has_none(foreign, bare):
    for on in (True, False):
        setup = settle(load_scenario("safe-simulation", {"guard.enabled": on}), "mb")
        case = CosimSetup(setup, setup, setup if bare else None, foreign, {}, {}, at_once=False)
        assert (case.limiter == "guard") is (on and (foreign or bare))
