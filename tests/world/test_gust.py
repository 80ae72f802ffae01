"""Gusts."""

import math

import numpy as np
import pytest
from scipy.signal import lfilter

from tests.world.motion import EFFECTS, bound_of, fed_to, motion
from wmr_ctrl.world.gust import GUST


def test_it_is_numbers_behind_a_filter_and_pushes_by_its_size_at_most():
    columns = motion()
    keep = math.exp(-0.01 / 0.1)
    share = lfilter([1 - keep], [1, -keep], columns["gust"], axis=0)

    assert fed_to(GUST, EFFECTS["gust"], columns) == pytest.approx(share * [5.0, 1.0], abs=1e-12)
    assert bound_of(GUST, EFFECTS["gust"]).dbar == (5.0, 1.0)
    assert np.abs(share).max() > 0.1
