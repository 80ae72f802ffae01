"""Gusts."""

import pytest

from tests.world import twins
from tests.world.motion import EFFECTS, assert_is_twin, bound_of
from wmr_ctrl.world.gust import GUST


@pytest.mark.slow
def test_it_is_its_twin():
    twin = twins.GustTwin({"size": (5.0, 1.0), "time": 0.1, "T": 0.01})

    assert_is_twin(GUST, EFFECTS["gust"], twin)


def test_it_pushes_by_its_size_at_most():
    assert bound_of(GUST, EFFECTS["gust"]).dbar == (5.0, 1.0)
