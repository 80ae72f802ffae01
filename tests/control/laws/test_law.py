"""Common properties of laws: titles, damping, and the commands they predict over."""

import pytest

from tests.control.laws.points import T
from wmr_ctrl.control.laws.law import Basis, Law, Traits, commands_predicted, no_rule
from wmr_ctrl.control.laws.pid import PidGains
from wmr_ctrl.control.laws.prox import ProxGains


@pytest.mark.parametrize("delay, count", [
    (0.0, 0), (0.03, 3), (0.07, 7), (0.0300001, 4), (0.0299, 3), (1e-4, 1),
])  # fmt: skip
def test_commands_are_predicted_over_a_delay_as_its_decimals_say(delay, count):
    assert commands_predicted(ProxGains(delay=delay), T) == count
    assert commands_predicted(ProxGains(delay=delay / 7), T / 7) == count


def test_a_law_is_called_by_the_first_line_of_its_file():
    named = (
        Law("toy", PidGains, lambda context: context, Traits(), doc) for doc in (None, "A b.\nc")
    )

    assert [law.title for law in named] == ["toy", "A b"]


def test_a_loop_decays_half_as_fast_as_its_square():
    basis = Basis((1.0,) * 3, (8.0, 6.0), 1.0, 1.0, (50.0, 5.0), 1.0, (1.0, 1.0), (1.0, 1.0))

    assert basis.rate == (4.0, 3.0)
    assert basis.damping == (200.0, 15.0)
    assert no_rule(basis) == {}
