"""The price of the guard: the steady speeds that remain usable."""

from dataclasses import replace

from tests.papers_robot import paper
from wmr_ctrl.control.guard.price import early_speed, speed_price, torque_swing, usable_formula
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.scenario import override


def priced(**changed):
    scenario = override(paper(), {"guard.enabled": True, "disturbance.truncate": 3.0, **changed})
    return scenario, settle(scenario, "prox").guard


def test_a_larger_push_leaves_less_and_nothing_beats_what_cannot_be():
    less = [speed_price(*priced(**{"guard.dbar": [push, 15.0]})) for push in (60.0, 120.0)]

    assert less[0].usable[0] > less[1].usable[0]
    assert less[0].usable[1] == less[1].usable[1]
    assert all(item.usable[k] <= item.unbeatable[k] for item in less for k in (0, 1))
    assert less[0].short == tuple(a > b for a, b in zip(less[0].asked, less[0].usable, strict=True))


def test_without_delay_or_noise_nothing_is_early_and_nothing_swings():
    scenario, guard = priced()

    assert early_speed(guard) == (0.0, 0.0)
    assert (
        early_speed(replace(guard, delay=(0.1, 0.1), dbar=(1.0, 1.0), f_min=(2.0, 0.5)))[0] == 0.0
    )
    assert usable_formula(guard, 0).endswith("(1/alpha + delay)/M_min")
    assert torque_swing(scenario.robot, guard, 0) == 0.0 or any(map(float, guard.nbar))
