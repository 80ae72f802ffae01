"""Outputs that hold only a part of the loop."""

import pytest

from tests.papers_robot import paper
from tests.tables import changes
from wmr_ctrl.control.loop import LoopGraphs
from wmr_ctrl.control.outside import check_plain_loop
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.world.scenario import override


def test_noise_at_the_wheels_comes_from_outside_and_nothing_else_does():
    noisy = override(paper(), {"disturbance.std": 0.5})
    check_plain_loop(settle(noisy, "mb"), "the kit")

    windy = override(noisy, changes("gust.size = [1.0, 0.0]"))
    with pytest.raises(
        ArgumentError, match=r"the kit holds only .* also has: gust \(\[gust\]\)\. Export"
    ):
        check_plain_loop(settle(windy, "mb"), "the kit")


def test_a_plant_outside_has_no_brake():
    base = changes("base.kind = velocity; limits.v_u1 = [1, 2]; base.rest = 0.8")
    with pytest.raises(ArgumentError, match=r"base\.rest = 0\.8: .* no brake"):
        LoopGraphs(settle(override(paper(), base), "kanayama"), external_plant=True)
