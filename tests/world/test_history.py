"""The memory of past samples."""

import casadi as ca

from wmr_ctrl.core.signals import Signal
from wmr_ctrl.world.history import history


def test_values_age_by_a_sample_and_the_first_one_counts_as_all_before():
    now, first = ca.SX.sym("now"), ca.SX.sym("first")
    seen = history(Signal("toy", "m", "toy"), now, first, 2)
    symbols = [now, first, *(item.sym for item in seen.state)]
    step = ca.Function("step", symbols, [ca.vertcat(*seen.aged), *ca.vertsplit(seen.update)])

    kept, shown = [7.0, 7.0], []
    for value in (1.0, 2.0, 3.0, 4.0):
        aged, *kept = step(value, value == 1.0, *kept)
        shown.append(aged.full().ravel().tolist())

    assert [item.signal.name for item in seen.state] == ["toy_1", "toy_2"]
    assert shown == [[1, 1, 1], [2, 1, 1], [3, 2, 1], [4, 3, 2]]
