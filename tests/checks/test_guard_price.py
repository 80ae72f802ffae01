"""Messages on the price of the guard, before a guarded run."""

import re

import pytest

from tests.tables import changes
from wmr_ctrl import simulate
from wmr_ctrl.control.guard.price import speed_price
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.scenario import load_scenario


def test_the_price_is_that_of_the_largest_friction_of_the_run(loop):
    """The usable speed is v_u1 - (mu m g + dbar)/(M_min alpha).

    The change with the largest friction gives mu and m.
    """
    numbers = """
        guard.enabled = true; guard.M_min = [25.0, 2.7]; guard.dbar = [60.0, 10.0]
        changes = [{t = 5.0, mu = 0.3}, {t = 9.0, mu = 0.1, m = 55.0}]
    """
    of = loop("prox", changes(numbers))
    price = speed_price(of.scenario, of.setup.guard)
    friction = 0.3 * of.scenario.robot.m * of.scenario.robot.g

    assert price.usable[0] == pytest.approx(1 - (friction + 60) / (25 * 100), rel=1e-9)
    assert price.usable[1] == pytest.approx(1.5 - 10 / (2.7 * 100), rel=1e-9)


def test_a_reference_asks_for_as_much_backwards(loop):
    asked = []
    for speed in (0.7, -0.7):
        line = f"guard.enabled = true; reference.kind = line; reference.speed = {speed}"
        of = loop("prox", changes(line))
        asked.append(speed_price(of.scenario, of.setup.guard).asked)

    assert asked[0] == asked[1] == (0.7, 0.0)


NARROW = {"limits.v_u1": [1.0, 0.11], "limits.v_u2": [0.8, 0.105]}
"""The reference asks for 0.1 rad/s, and the guard leaves 0.11 - 15 * 0.01/4.86."""


@pytest.mark.parametrize("delay", [0.0, 0.02])
def test_the_robot_turns_as_fast_as_is_usable_on_average(delay):
    """A robot commanded to turn faster than is usable reaches the usable rate and keeps it.

    No push acts on the robot.
    """
    changed = {**NARROW, "actuator.delay": delay, "disturbance.std": 0.0, "guard.dbar": [60.0, 8.0]}
    scenario = load_scenario("safe-simulation", changed)
    price = speed_price(scenario, settle(scenario, "prox").guard)
    run = simulate("safe-simulation", "prox", overrides=changed)
    late = run["omega"][len(run["omega"]) // 2 :]

    assert run.settings.usable == price.usable
    assert run.settings.asked == price.asked
    assert price.short == (False, True)
    assert late.mean() == pytest.approx(price.usable[1], rel=1e-2)


UNBOUNDED = """
    encoder.counts = 1024.0; encoder.method = time
    sensor.velocity_losses = 3
    motor.stall = 40.0; motor.free = 20.0
    disturbance.truncate = inf
"""


@pytest.mark.parametrize("text", UNBOUNDED.strip().splitlines())
def test_a_voided_guarantee_names_a_key_of_the_scenario(told, text):
    """`check --only KEY` and the table take it."""
    found = told("prox", changes(text), scenario="safe-simulation")
    (void,) = [
        item for item in found
        if "guard.alpha." in item.sentence or "for a guarantee" in item.sentence
    ]  # fmt: skip

    assert void.key in changes(text)


def test_a_slow_rate_of_approach_is_told_to_be_raised(told):
    """A shorter period hardly raises the usable speed if guard.alpha is stated."""
    fast = {"reference.kind": "line", "reference.speed": 0.7}
    (found,) = told("pid", fast, scenario="robot-10ms", key="guard.dbar")

    assert "Raise guard.alpha, or state" in found.sentence
    for faster, left in (({"guard.alpha": 25.0}, []), ({"clock.control": 0.005}, [found.key])):
        again = told("pid", {**fast, **faster}, scenario="robot-10ms", key="guard.dbar")
        assert [item.key for item in again] == left


@pytest.mark.parametrize("error, calm", [(0.06, True), (0.1, False)])
def test_only_a_rate_that_the_guard_takes_is_proposed(told, error, calm):
    stated = {"guard.nbar": [error, 0.015], "guard.alpha": 5.0, "disturbance.std": 0.8}
    (found,) = told("pid", stated, scenario="robot-10ms", key="guard.alpha")
    said = re.search(r"Choose guard\.alpha = (\S+) 1/s", found.sentence)

    assert bool(said) is calm
    if said:
        stated["guard.alpha"] = float(said[1])
        assert told("pid", stated, scenario="robot-10ms", key="guard.alpha") == []
    else:
        assert "is as calm as that: measure better." in found.sentence
