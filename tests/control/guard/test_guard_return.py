"""From outside the limits: back within the stated number of samples, and not through the other."""

from __future__ import annotations

import math

import numpy as np
import pytest

from wmr_ctrl.api import simulate
from wmr_ctrl.control.setup import settle
from wmr_ctrl.results import Run
from wmr_ctrl.world.scenario import load_scenario

TRUNCATED = {"disturbance.truncate": 3.0, "clock.duration": 20.0}


def returning(law: str, **changed: object) -> Run:
    return simulate("outside-start", law, guard=True, overrides={**TRUNCATED, **changed})


def stated_samples(law: str, **changed: object) -> int:
    """ceil((v0 - v_u1) M_max/(T (brake - dbar))) of the slower axis."""
    scenario = load_scenario("outside-start", {**TRUNCATED, "guard.enabled": True, **changed})
    guard = settle(scenario, law).guard
    start, period = scenario.initial.velocity, scenario.clock.control
    return max(
        math.ceil((start[i] - u1) * guard.M_max[i] / (period * (guard.brake[i] - guard.dbar[i])))
        for i, u1 in enumerate(scenario.limits.v_u1)
    )


@pytest.mark.parametrize(
    ("law", "changed"),
    [
        ("pid", {}),
        ("smc", {"actuator.tau_max": 20.0}),
        ("mb", {"actuator.tau_max": 10.0}),
        ("nn", {}),
        ("prox", {"actuator.tau_max": 20.0}),
        ("kanayama", {"actuator.tau_max": 10.0}),
        ("pursuit", {}),
    ],
)
@pytest.mark.slow_but("pid-changed0", "mb-changed2")
def test_back_inside_within_the_stated_samples(law: str, changed: dict[str, object]) -> None:
    run = returning(law, **changed)

    outside = (abs(run["v1"]) > 1.0) | (abs(run["omega"]) > 1.5)
    assert 0 < np.count_nonzero(outside) <= stated_samples(law, **changed)
    assert not outside[np.count_nonzero(outside) :].any()
    assert run["v1"].min() >= -1.0
    assert run["omega"].min() >= -1.5


def test_speed_outside_never_grows() -> None:
    run = returning("pid", **{"actuator.tau_max": 10.0})

    for name, limit in (("v1", 1.0), ("omega", 1.5)):
        outside = run[name][run[name] > limit]
        assert (np.diff(outside) <= 0).all()
