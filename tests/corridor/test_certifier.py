"""Each step of the certificate bounds what it says it bounds, for deviations made by hand."""

from copy import copy
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.control.bases import VELOCITY, based
from tests.papers_robot import safe
from tests.tables import changes
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.corridor.answer import Corridor
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.corridor.certificate import Certifier
from wmr_proofs.corridor.inputs import Inputs, NoCorridorError, at_first, bounded_inputs
from wmr_proofs.corridor.masses import _with_robots
from wmr_proofs.corridor.reckoning import Reckoning

NOISE = np.array([0.002, 0.004])
NOISY = {"sensor.velocity_noise": NOISE.tolist(), "guard.enabled": False}


@pytest.fixture(scope="module")
def certifier():
    """Certifier of a law with an observer and errors of measured velocities."""
    return Certifier(settle(safe(NOISY), "kanayama"))


def test_inputs_are_as_large_as_the_scenario_says():
    """A position has both of its errors; a command is off by half a step to either side."""
    noisy = changes("""
        sensor.pose_noise = 0.03
        sensor.velocity_noise = [0.01, 0.02]
    """)
    inputs = bounded_inputs(settle(safe(noisy), "prox"))
    assert inputs.pose == pytest.approx(np.hypot(0.03, 0.03))
    assert inputs.velocity.tolist() == [0.01, 0.02]
    based = changes("""
        base.quantum = [0.002, 0.01]
        base.deadband = [0.02, 0.03]
        filter.kind = clip
    """)
    inputs = bounded_inputs(settle(load_scenario("turtlebot3-burger", based), "prox"))
    assert inputs.command == pytest.approx([0.001, 0.005])
    assert inputs.dead.tolist() == [0.02, 0.03]


def test_a_condition_has_less_room_where_what_it_limits_is_measured_amiss(certifier):
    loop = certifier.loop
    room = np.array([float(item.lower()) for item in loop.most])
    off = [0.0 if item.measured is None else NOISE[item.measured] for item in loop.conditions]

    assert certifier.most == pytest.approx(room - off, rel=1e-9)
    assert any(off)
    limits = zip(room, loop.conditions, strict=True)
    least, axis = min((most, x.measured) for most, x in limits if x.measured is not None)
    loud = {**NOISY, "sensor.velocity_noise": [1.001 * least * (k == axis) for k in range(2)]}
    with pytest.raises(NoCorridorError, match="and the measured velocity is off by"):
        Certifier(settle(safe(loud), "kanayama"))


@pytest.mark.parametrize("share, broken", [(0.99, False), (1.01, True)])
def test_a_condition_that_is_used_by_more_than_all_is_broken(certifier, share, broken):
    tube = replace(certifier._tube(certifier.linear(certifier.inputs)), share=share)
    if broken:
        with pytest.raises(NoCorridorError, match="may reach"):
            certifier._check(tube)
    else:
        certifier._check(tube)


def test_commands_that_may_be_small_may_be_taken_for_none(certifier):
    """The dead band is half the command on the reference."""
    level = np.abs(certifier.loop.remains[:2])
    inputs = replace(certifier.inputs, dead=0.5 * level)
    still, moved = (certifier._law_rest(inputs, share * level)[:2] for share in (0.4, 0.6))

    assert level.max() > 0
    assert moved - still == pytest.approx(inputs.dead, rel=1e-9)


def test_a_start_counts_what_was_measured_and_estimated_before_it(certifier):
    """Start, pose error and earlier estimates count one by one; without a start, none does."""
    one, inputs = copy(certifier), replace(certifier.inputs, pose=0.02)
    one.begun = 0.005
    blank = {name: np.zeros_like(getattr(certifier.gains.fast, name))
             for name in ("by", "steps", "constant", "start", "misled", "before")}  # fmt: skip
    nothing = np.zeros(len(certifier.law_rest))
    before = one._before(inputs, nothing)
    wanted = {"start": 1.0, "misled": 0.025, "before": before.sum()}
    for name, size in wanted.items():
        fast = replace(certifier.gains.fast, **{**blank, name: blank[name] + 1.0})
        one.gains = replace(certifier.gains, fast=fast)
        for started in (True, False):
            given = inputs, np.zeros(len(certifier.loop.names)), nothing, np.zeros(2), started
            assert one._peaks(*given).fast == pytest.approx(started * size)
    assert before.min() > 0


def test_an_error_that_is_reckoned_on_is_as_large_as_its_own_remainders_make_it():
    """The test iterates the bound itself, for a remainder that is the square of the error."""
    scenario = safe()
    curve = SimpleNamespace(
        remainders=lambda products: products[:3, None, :] * np.array([0.3, 0.2, 0, 0.5, 0]),
        value=lambda: [], at=np.array([0.0, 0.0, 0.0, 3.0, 2.0]),
    )  # fmt: skip
    loop = SimpleNamespace(reckoning=curve, setup=SimpleNamespace(scenario=scenario))
    reckoning, phi = Reckoning(loop, 3), np.array([[1, 0.1, 0], [-0.1, 1, 0.2], [0, 0, 1.0]])
    vars(reckoning).update(turning=phi, _rest=np.array([1e-4, 2e-4, 0.0]))
    linear = np.array([[1.0, 2.0, 1.0], [2.0, 2.5, 1.5], [2.5, 4.0, 2.0]]) * 1e-3
    inputs = Inputs(np.zeros(2), 0.01, NOISE, missing=3)
    measured = np.array([0.02, 0.03, 0.01, 0.1, 0.1])
    found = reckoning.added(inputs, measured, np.concatenate((np.zeros(7), linear.ravel())))

    powers = [np.abs(np.linalg.matrix_power(phi, k)) for k in range(3)]
    error = np.zeros(3)
    for _ in range(60):
        shown = measured + np.array([error[0] + 0.01, error[1] + 0.01, error[2], 0.0, 0.0])
        each = curve.remainders(np.outer(shown, shown)).sum(axis=(1, 2)) + reckoning._rest
        sums = np.cumsum([power @ each for power in powers], axis=0)
        error = (linear + sums).max(axis=0)
    assert (found.reckoned >= error).all()
    assert found.reckoned == pytest.approx(error, rel=0.01)


@pytest.mark.parametrize(
    "case, run, good",
    [
        (
            {"actuator.lag": 0.02},
            "no torque in its drives",
            "the torque that friction takes in its drives and a law that has asked for it",
        ),
        ({}, "", ""),
    ],
)
def test_what_drives_hold_at_first_is_nothing_in_a_run_and_what_rolls_on_for_good(case, run, good):
    setup = settle(safe(case), "kanayama")

    assert at_first(setup, run=True) == run
    assert at_first(setup, run=False).startswith(good)
    assert bool(at_first(setup, run=False)) is bool(good)


def test_what_a_base_that_takes_velocities_holds_at_first_is_told_part_by_part():
    late = based(VELOCITY, "base.delay = 0.02; base.accel = [1, 2]; base.decel = [1, 2]")
    setup = settle(late, "kanayama")

    assert at_first(setup, run=True) == "no command in transit and its ramp at that speed"
    assert at_first(setup, run=False) == (
        "commands of that speed in transit, its ramp at that speed and a law that has sent them"
    )


def test_another_robot_has_its_masses_at_all_times_and_is_believed_to_be_what_it_was():
    changes = [{"t": 20.0, "m": 60.0, "I": 7.0}, {"t": 30.0, "m": 45.0, "I": 6.0}]
    setup = settle(safe({"changes": changes}), "mb")
    believed = setup.scenario.believed
    other = _with_robots(setup, [(40.0, 5.0), (61.0, 7.1), (46.0, 6.1)]).scenario

    assert (other.robot.m, other.robot.I) == (40.0, 5.0)
    assert [(item.t, item.m, item.I) for item in other.changes] == [
        (20.0, 61.0, 7.1), (30.0, 46.0, 6.1),
    ]  # fmt: skip
    for key in ("m", "I", "mu"):
        assert getattr(other.believed, key) == getattr(believed, key)
        assert getattr(other.model, key) == getattr(believed, key)


def test_as_many_poses_may_be_missing_as_were_counted():
    known = SimpleNamespace(velocity=(0.0, 0.0), push=1.0, pose=0.0, missing=3)

    assert Corridor._while(known, 1.0).endswith(", no pose comes to up to 3 samples in a row")
