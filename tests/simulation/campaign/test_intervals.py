"""Confidence intervals against their definitions, and how often a stopping rule is right."""

import math

import numpy as np
import pytest

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.simulation.campaign.intervals import StopRule, bootstrap, of_share


def at_most(hits, count, share):
    """Probability of at most this number of hits."""
    return sum(math.comb(count, k) * share**k * (1 - share) ** (count - k) for k in range(hits + 1))


@pytest.mark.parametrize("hits, count", [(0, 10), (3, 10), (10, 10), (1, 200)])
def test_the_exact_interval_ends_where_the_tails_are_half_of_the_rest(hits, count):
    low, high = of_share(hits, count, 0.95)

    if hits < count:
        assert at_most(hits, count, high) == pytest.approx(0.025, rel=1e-7)
    if hits > 0:
        assert 1 - at_most(hits - 1, count, low) == pytest.approx(0.025, rel=1e-7)
    assert (low, high)[hits == count] == float(hits == count) or 0 < hits < count


def test_the_bootstrap_is_near_the_normal_interval_and_repeats():
    values = np.random.default_rng(1).normal(3.0, 2.0, 4000)
    low, high = bootstrap(values, 0.95, 7)

    assert (low, high) == bootstrap(values, 0.95, 7)
    assert (high - low) / 2 == pytest.approx(1.96 * values.std() / math.sqrt(4000), rel=0.1)


@pytest.mark.parametrize("share", [True, False])
def test_more_looks_need_a_narrower_interval(share):
    """Confidence of each of J looks is 1 - (1 - c)/J: a width that one look accepts, ten refuse."""
    values = (np.arange(200) % 4 == 0).astype(float)
    figure, key = ("violated", "position_rms")[not share], 3
    widths = []
    for confidence in (0.95, 0.995):
        rule = StopRule(figure=figure, half_width=1.0)
        low, high = rule.bounds(values, confidence, key)
        widths.append((high - low) / 2)
    between = StopRule(figure=figure, half_width=sum(widths) / 2)

    assert widths[0] < 0.9 * widths[1]
    assert between.reached(values, 1, key)
    assert not between.reached(values, 10, key)


@pytest.mark.parametrize("wrong", [{"half_width": 0}, {"confidence": 1.0}, {"first": 1}])
def test_a_rule_without_sense_is_refused(wrong):
    with pytest.raises(ScenarioError, match=r"stop\."):
        StopRule(**{"figure": "violated", "half_width": 0.1, **wrong})
