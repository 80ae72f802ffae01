"""Settings: sample times, impossible numbers, and a log's evidence of its disturbance."""

import math

import numpy as np
import pytest

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.results import Settings
from wmr_ctrl.results.settings import (
    Assumptions,
    admitted,
    first_beyond,
    largest_push,
    stopping_force,
)


@pytest.mark.parametrize("control", [0.001, 0.01, 0.1, 1 / 3, 0.7])
def test_every_sample_time_finds_its_own_index(control):
    settings = Settings(control, control, 1000 * control, (1.0, 1.0), 0.0)

    assert settings.samples == 1000
    assert [settings.index(k * control) for k in range(1001)] == list(range(1001))
    assert [settings.index((k + 0.5) * control) for k in range(1000)] == list(range(1, 1001))


@pytest.mark.parametrize(
    "fields",
    [
        {"control": 0.0},
        {"plant": -0.001},
        {"duration": float("inf")},
        {"split": float("nan")},
        {"rms_from": -1.0},
        {"v_u1": (1.0, 0.0)},
        {"v_u1": (float("nan"), 1.0)},
    ],
)
def test_impossible_settings_are_refused_by_name(fields):
    good = {"control": 0.01, "plant": 0.001, "duration": 1.0, "v_u1": (1.0, 1.5), "split": 0.5}

    with pytest.raises(ArgumentError, match=next(iter(fields))):
        Settings(**{**good, **fields})  # type: ignore[arg-type]


def test_the_first_push_beyond_its_bound_is_found_but_for_rounding():
    bounds = Assumptions(dbar=(3.0, 1.0), force=stopping_force((50.0, 5.0), (1.0, 2.0), 0.01))
    at_most = np.array(admitted(bounds.dbar, bounds.force))
    least = np.array([[0.0, 0.0], at_most, at_most * [1.0, 1.001], [9.0, 0.0]])
    columns = {"t": np.arange(4) * 0.1, "d_least": least}

    assert bounds.force == (5000.0, 1000.0)
    assert tuple(at_most) == pytest.approx((3.005, 1.001))
    assert first_beyond(columns, bounds) == (pytest.approx(0.2), 2)
    assert first_beyond({**columns, "d_least": least[:2]}, bounds) is None
    assert first_beyond({"t": columns["t"]}, bounds) is None


def test_the_largest_push_passes_over_what_is_no_number():
    least = np.array([[1.0, math.nan], [math.nan, 0.5], [0.2, 0.1]])

    assert largest_push({"d_least": least}) == (1.0, 0.5)
    assert largest_push({"d_least": least[:1]}) is None
    assert largest_push({}) is None
