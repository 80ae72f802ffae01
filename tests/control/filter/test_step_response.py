"""The clip of linear loops with slew, against the worst commands that change so slowly."""

from itertools import product

import numpy as np
import pytest
from scipy.signal import lti, step

from tests.control.filter.test_peak_gain import LOOP, WIDE, scenario
from tests.tables import cases, changes
from wmr_ctrl import command_filter
from wmr_ctrl.control.filter.enclosure import Span
from wmr_ctrl.control.filter.peak_gain import PiLoop
from wmr_ctrl.control.filter.step_response import (
    _between,
    _left,
    band,
    deviation,
    pi_cells,
    swing,
)
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario import override


@pytest.mark.slow
def test_commands_change_no_faster_than_stated_and_both_axes_together():
    step = command_filter(scenario(slew=(0.1, 0.25), push=(0.0, 0.0))).step
    sent = np.array([(0.0, 0.0)] + [step(asked).command for asked in
                    [(0.5, 0.2)] * 40 + [(-0.5, 0.1)] * 40 + [(np.nan, 0.0)] * 90])  # fmt: skip
    assert (np.abs(np.diff(sent, axis=0)) <= np.array([0.1, 0.25]) * 0.05 * (1 + 1e-12)).all()
    assert sent[40] == pytest.approx(0.4 * np.array([0.5, 0.2]))  # on the way, curvature kept
    assert sent[-1] == pytest.approx([0.0, 0.0], abs=1e-12)


@pytest.mark.parametrize("ki, rate", [(100.0, 0.3), (900.0, 1.545)])
def test_a_response_and_what_bounds_it_afterwards_are_those_of_one_loop(ki, rate):
    M, kp, c, times = 50.0, 150.0, 5.0, np.linspace(0, 6, 6001)
    cells = pi_cells(PiLoop((M, M), (kp, kp), (ki, ki), (c, c)))[:1]
    e, speed = deviation(cells, Span.of(times[None]))
    _, S = step(lti([kp, ki], [M, kp + c, ki]), T=times)
    np.testing.assert_allclose(e.lo[0], 1 - S, atol=1e-9)
    np.testing.assert_allclose(speed.lo[0], -np.gradient(S, times), atol=0.01)
    assert (np.abs(1 - S) * np.exp(rate * times) <= _left(cells, e, speed, rate, 0)[0]).all()
    assert np.isinf(_left(cells, e, speed, 1.6, 0)).all()


def test_a_piece_lies_between_its_ends_and_what_bends_it():
    lower, upper = _between(Span.of(np.array([[0.0, 1.0, 0.5]])), np.array([[0.1, 0.2]]))
    assert lower[0] == pytest.approx([-0.1, 0.3])
    assert upper[0] == pytest.approx([1.1, 1.2])


@pytest.mark.slow
def test_no_member_swings_longer_than_its_family_and_the_slowest_nearly_as_long():
    swings = []
    for numbers in product(*WIDE.values()):
        M, kp, ki, c = numbers
        times = np.linspace(0, 40, 2001)
        _, S = step(lti([kp, ki], [M, kp + c, ki]), T=times)
        reached = int(np.argmax(S >= 1))
        swings.append(float(np.trapezoid(np.abs(1 - S)[reached:], times[reached:])))
    assert 0.95 * swing(pi_cells(LOOP)) < max(swings) < swing(pi_cells(LOOP))


@pytest.mark.parametrize(
    "stated, words",
    cases("""
        filter.slew = [1.2, 0.1]                        | brings no gain: from 0.9 | slow
        filter.slew = [0.1, 0.1]; filter.hold = 0.5     | stops on its own
        filter.slew = [0.1, 0.1]; filter.kind = band    | filter.slew is for
        filter.slew = [0.1, 0.1]; filter.jitter = 0.05  | less than the period
    """),
)
def test_a_slew_that_cannot_be_counted_on_is_refused(stated, words):
    with pytest.raises(ScenarioError, match=words):
        command_filter(override(scenario(), changes(stated)))


@pytest.mark.slow
def test_loops_of_two_parts_that_differ_too_much_are_refused_with_what_helps():
    """Loops with two very different poles are refused; a swing of 0.01 s was once reported as 0."""

    def cells(kp, ki):
        return pi_cells(PiLoop((55.0, 55.0), (kp, kp), (ki, ki), (0.0, 0.0)))

    words = r"Lower the upper end of kp .* lower end of ki"
    with pytest.raises(ScenarioError, match=words):
        swing(cells(5e3, 1e3))
    with pytest.raises(ScenarioError, match=words):
        band(cells(4e4, 5e4), 0.05, 8, 128)
    assert swing(cells(5e2, 1e3)) > 0.01
    assert swing(cells(5e3, 1e4)) > 5e-3
