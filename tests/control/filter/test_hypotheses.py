"""Commands that act are off what was sent: rounded by the base, or worse, by an adversary."""

import numpy as np
import pytest

from benchmarks.filter_trials.linear_base import pi_base
from tests.control.filter.test_band import CORNERS
from tests.control.filter.test_peak_gain import scenario
from tests.tables import changes
from wmr_ctrl import command_filter
from wmr_ctrl.control.filter.hypotheses import broken_hypotheses
from wmr_ctrl.world.effect import Bound
from wmr_ctrl.world.scenario import override

T, COUNT = 0.05, 140
ERROR = 0.04


def fastest(kind, error, quantum=0.0):
    """Largest |v| of some corners, behind a filter that is told of ERROR."""
    limit, worst = command_filter(scenario(kind=kind, d=(ERROR, 0.0), push=(0.0, 0.0))), 0.0
    for base in (*CORNERS[::5], pi_base(65, 135, 330, 0)):
        ahead = base.signs(base.b, (np.arange(COUNT) + 0.5) * T)
        for wish in (ahead, np.ones(COUNT)):
            limit.start()

            def acts(k, wish=wish, ahead=ahead):
                u = limit.step((9.0 * wish[k], 0.0)).command[0]
                return quantum * np.round(u / quantum) if quantum else u + error * ahead[k]

            worst = max(worst, np.abs(base.speeds(acts, [T] * COUNT, parts=1)).max())
    return worst


@pytest.mark.parametrize("kind", ["clip", "band"])
@pytest.mark.slow_but("clip")
def test_an_error_that_is_stated_keeps_the_limit(kind):
    assert 0.94 < fastest(kind, ERROR) <= 1.0
    assert fastest(kind, 0.0, quantum=2 * ERROR) <= 1.0


@pytest.mark.parametrize("kind", ["clip", "band"])
@pytest.mark.slow_but("clip")
def test_an_error_that_is_not_stated_breaks_the_limit(kind):
    assert fastest(kind, 2 * ERROR) > 1.0


def test_a_quantum_must_be_stated():
    stated = scenario(kind="band", d=(0.01, 0.0), push=(0.0, 0.0))
    base = override(stated, changes("""
        base.kind = velocity
        base.loop = pi
        robot.mu = 0.0
        robot.m = 60.0
        changes = []
        base.kp = 150.0
        base.ki = 300.0
    """) | {"robot.I": 60 / 16})  # fmt: skip
    assert not broken_hypotheses(base, Bound(command=(0.01, 0.0)))
    (sentence,) = broken_hypotheses(base, Bound(command=(0.02, 0.0)))
    assert "off by 0.02 m/s (base.quantum). Raise filter.d[1] = 0.01 to that." in sentence
