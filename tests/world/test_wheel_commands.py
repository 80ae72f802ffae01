"""Dead bands and ramps of wheels, from their graph."""

import math

import numpy as np
import pytest

from tests.world.motion import acting
from wmr_ctrl.world.scenario import load_scenario, override
from wmr_ctrl.world.wheel_commands import WHEEL_COMMANDS

CREATE3 = load_scenario("irobot-create3", {"clock.duration": 10.0})
L = CREATE3.robot.l
BAND = 0.03


def behind(changes, commands):
    """Commands (n, 2) behind the firmware of the wheels."""
    return acting(override(CREATE3, changes), commands, effect=WHEEL_COMMANDS)


def rims(pairs):
    return np.stack([pairs[:, 0] + L * pairs[:, 1], pairs[:, 0] - L * pairs[:, 1]], axis=1)


def test_a_wheel_within_its_dead_band_stands_and_the_other_turns():
    commands = np.random.default_rng(1).uniform(-1, 1, (500, 2)) * (0.08, 0.6)
    wanted, got = rims(commands), rims(behind({"base.wheel_deadband": BAND}, commands))
    assert got == pytest.approx(np.where(np.abs(wanted) < BAND, 0.0, wanted), abs=1e-15)
    assert 0.2 < (np.abs(wanted) < BAND).mean() < 0.8


@pytest.mark.parametrize("accel, decel", [(0.5, 0.5), (0.4, 1.2), (math.inf, 0.6)])
def test_rims_change_no_faster_than_their_ramps(accel, decel):
    commands = np.repeat(np.random.default_rng(2).uniform(-1, 1, (40, 2)) * (0.3, 1.5), 50, axis=0)
    ramps = {"base.wheel_accel": accel, "base.wheel_decel": decel}
    got, h = rims(behind(ramps, commands)), CREATE3.clock.plant
    before = np.vstack([np.zeros((1, 2)), got[:-1]])
    away = np.abs(got) > np.abs(before)
    assert (np.abs(got - before) <= h * np.where(away, accel, decel) + 1e-12).all()
    assert (got * before >= -1e-15).all()  # a rim stops at 0 before it turns round
    reached = rims(commands)[49::50]
    assert (np.abs(got[49::50] - reached) < 1e-12).any(axis=1).mean() > 0.1


def test_a_wheel_kept_at_rest_changes_the_command_by_half_of_its_dead_band_at_most():
    """`dropped` bounds the change of a command with one wheel in its dead band, and is tight."""
    changes = {"base.wheel_deadband": BAND}
    told = np.array(WHEEL_COMMANDS.bounded(override(CREATE3, changes)).dropped)
    commands = np.random.default_rng(3).uniform(-2, 2, (4000, 2)) * (BAND, BAND / L)
    one = np.abs(rims(commands)) < BAND
    alone = one.sum(axis=1) == 1
    off = np.abs(behind(changes, commands) - commands)[alone]

    assert (off <= told * (1 + 1e-12)).all()
    assert (off.max(axis=0) > 0.98 * told).all()


@pytest.mark.parametrize(
    "changes, off",
    [({"base.wheel_deadband": BAND}, BAND / 2),
     ({"base.wheel_accel": 0.9, "base.wheel_decel": 0.9}, 0.9e-3),
     ({"base.wheel_deadband": BAND, "base.wheel_accel": 0.9, "base.wheel_decel": 0.9},
      BAND / 2 + 0.9e-3)],
)  # fmt: skip
def test_wheels_take_a_command_off_by_half_of_the_dead_band_and_a_step_of_the_ramp(changes, off):
    bound = WHEEL_COMMANDS.bounded(override(CREATE3, changes))

    assert bound.command == pytest.approx((off, off / L))
