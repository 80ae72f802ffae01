"""Lost commands, and a base that stops if it receives none."""

import numpy as np
import pytest

from tests.world.motion import acting, based
from wmr_ctrl.world.command_loss import COMMAND_LOSS


def test_commands_are_lost_so_often_in_a_row_and_no_more():
    sent = np.repeat(np.arange(1.0, 61.0), 50)
    wanted = np.column_stack((sent, -sent))
    found = acting(based(losses=2), wanted, [-1.0] * len(sent))
    heard = np.unique(found[150:, 0])
    assert np.diff(heard) == pytest.approx(3.0)
    assert (found[:100] == 0).all()


def test_behind_a_delay_a_command_is_lost_at_the_step_at_which_it_arrives():
    sent = np.linspace(0.1, 1.0, 400)
    found = acting(based(losses=1, delay=0.02), np.column_stack((sent, sent)), [1.0] * 400)

    assert [*np.flatnonzero(np.diff(found[:, 0])) + 1] == [*range(20, 400, 50)]


def test_a_base_that_hears_nothing_stops_after_its_time_out():
    wanted = np.full((400, 2), 0.3)
    found = acting(based(losses=100, timeout=0.12), wanted, [1.0] * 50 + [-1.0] * 350)
    assert (found[:121] == 0.3).all()
    assert (found[121:] == 0.0).all()


@pytest.mark.parametrize("losses, timeout, stops, acts", [
    (2, 0.149, True, True), (2, 0.15, False, True), (34, 1.75, False, True),
    (0, 0.05, False, False), (0, 0.049, True, True), (0, 1.0, False, False),
])  # fmt: skip
def test_a_base_stops_between_commands_where_its_time_out_is_shorter(losses, timeout, stops, acts):
    scenario = based(losses=losses, timeout=timeout)

    assert bool(COMMAND_LOSS.bounded(scenario).hidden) is stops
    assert COMMAND_LOSS.active(scenario) is acts
    assert COMMAND_LOSS.bounded(scenario).losses == losses
