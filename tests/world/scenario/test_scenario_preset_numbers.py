"""What presets' files state, as `presets.txt` has it; gains and the robots that they are for.

After a change that is meant, `python -m tests.world.scenario.test_scenario_preset_numbers` writes
the list anew.
"""

import tomllib
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from wmr_ctrl.control.laws.prox import guide
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.scenario import load_scenario, preset_names

LIST = Path(__file__).with_name("presets.txt")
ON_THE_MARKET = ("turtlebot3-burger", "turtlebot3-waffle", "irobot-create3", "clearpath-husky",
                 "clearpath-jackal")  # fmt: skip


def tables(place, content):
    """A line a table: what it states by itself, then those within."""
    own = {key: value for key, value in content.items() if not isinstance(value, dict)}
    if own:
        yield f"{place}: {', '.join(f'{key} = {value}' for key, value in own.items())}"
    for key, value in content.items():
        if isinstance(value, dict):
            yield from tables(f"{place} {key}", value)


def listed():
    for name in preset_names():
        text = (files("wmr_ctrl.world.scenario") / "presets" / f"{name}.toml").read_text("utf-8")
        yield from tables(name, {k: v for k, v in tomllib.loads(text).items() if k != "title"})


def test_a_preset_is_the_robot_that_it_was():
    assert list(listed()) == LIST.read_text(encoding="utf-8").splitlines()


@pytest.mark.parametrize("name", ON_THE_MARKET)
def test_gains_of_a_robot_are_those_of_the_guide_times_its_own_mass_and_inertia(name):
    """For the delay and half the time constant of its base, at the reference's speed."""
    scenario = load_scenario(name)
    robot, base, path = scenario.robot, scenario.base, scenario.reference
    late = base.delay + base.tau[0] / 2
    fit = guide(scenario.clock.control, late, abs(path.radius * path.rate))
    prox, mb, nn = (settle(scenario, law).gains for law in ("prox", "mb", "nn"))

    assert settle(scenario, "prox").kinematics.k == pytest.approx(fit.k, rel=5e-3)
    assert prox.rho == pytest.approx(fit.rho, rel=5e-3)
    assert prox.wo == pytest.approx(fit.wo, rel=5e-3)
    assert mb.rho == prox.rho
    assert nn.rho1 == pytest.approx(np.array(prox.rho) * (robot.m, robot.I), rel=5e-3)


if __name__ == "__main__":
    LIST.write_text("".join(f"{item}\n" for item in listed()), encoding="utf-8")
