"""Laws behind the filter remember the command sent, not their own command: nothing winds up."""

import numpy as np
import pytest

import wmr_ctrl
from tests.tables import changes
from wmr_ctrl.control.controller import unfiltered_controller
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.scenario import load_scenario, override

LATE = changes("""
    changes = []
    clock.control = 0.02
    clock.duration = 25
    base = {kind = "velocity", tau = [0.2, 0.25], delay = 0.02}
    limits = {v_u1 = [1.0, 2.0], v_u2 = [0.9, 1.8]}
    filter.kind = governor
    filter.tau = [0.2, 0.3]
    filter.gain = [0.9, 1.1]
    filter.delay = [0.0, 0.03]
    reference.rate = 0.35
    gains.kinematics.k = [3.0, 20.0, 4.0]
    gains.prox = {rho = [8.0, 8.0], wo = 3.0}
    gains.kanayama = {k = [2.0, 8.0, 5.0], share = 1.0}
    gains.pursuit.share = 1
""")
"""A base that is 20 ms late, at 20 ms, and laws that ask for all of the limit."""
LAWS = ("kanayama", "pursuit", "prox")
HELD = 500


def scenario(**changes):
    plain = load_scenario("paper-simulation-noise-free")
    return override(plain, {**LATE, **{k.replace("__", "."): v for k, v in changes.items()}})


def held_back(law, told):
    """Memory and request of a law, sample by sample, while the base stands still far from the path.

    ``told(asked)`` is the command that the law is told was sent.
    """
    system = unfiltered_controller(settle(scenario(), law))
    step = system.function("step", [system.update, system.y])
    row = [3.0, 0.0, 0.0, 0.4, 0.2, 0.0, 0.0, -2.0, -3.0, 0.7, 0.0, 0.0]
    x, found = system.x0, []
    for _ in range(HELD):
        wish = step([*row, 0.0, 0.0], x, system.p0)[1].full().ravel()
        x, _ = step([*row, *told(wish)], x, system.p0)
        found.append([*x.full().ravel(), *wish])
    return np.array(found)


@pytest.mark.parametrize("law", [*LAWS, "mb", "smc"])
def test_a_law_that_is_held_back_stays_as_it_is(law):
    found = held_back(law, lambda _: (0.0, 0.0))

    assert np.abs(found[0, -2:]).max() > 0.03
    np.testing.assert_allclose(found[5:], np.tile(found[5], (HELD - 5, 1)), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(
    "law, kind", [("pursuit", "governor"), ("kanayama", "clip"), ("prox", "governor")]
)
@pytest.mark.slow_but("pursuit-governor")
def test_from_far_away_it_comes_to_the_path_and_stays(law, kind):
    """The filter acts for seconds; then no law has wound up."""
    far = {"initial__pose": [-6.0, -6.0, 2.5], "filter__kind": kind}
    run = wmr_ctrl.simulate(scenario(**far), law)
    away = np.hypot(run["e"][:, 0], run["e"][:, 1])

    assert run["clip_active"].any(axis=1).sum() * 0.02 > 1.0
    assert run.monitor.violations == 0
    assert away[-50:].max() < 1e-3
    if law == "prox":
        assert np.abs(run["d_hat"]).max() < 0.2
