"""The drive node over real DDS, in a namespace and with remapped topics: the run's bits."""

import numpy as np
import pytest

from tests.ros2.conftest import OVER_DDS, SLACK, TICK, Job, bar
from tests.ros2.lockstep import BASES, COMMON, carried_run, messages, sent_by
from wmr_ctrl.world.scenario import load_scenario, to_toml

pytestmark = [pytest.mark.slow, OVER_DDS]


def toml(reference):
    """A base that takes velocities, with a clip, along a reference."""
    return f"""
extends = "paper-simulation"
[limits]
v_u1 = [1.0, 2.0]
v_u2 = [0.7, 1.4]
[base]
kind = "velocity"
tau = [0.05, 0.05]
[clock]
control = 0.02
[filter]
kind = "clip"
gain = [0.9, 1.1]
d = [0.05, 0.05]
[disturbance]
std = 0.0
[reference]
{reference}
"""


WAY = toml('kind = "waypoints"\npoints = [[0.0, 0.0], [1.0, 0.0]]\nspeed = 0.3')
CIRCLE = toml('kind = "circle"\nradius = 1.0\nrate = 0.3')


def loop():
    """The run that messages come from, and the job that sends them."""
    law, changes = BASES["efforts, guard"]
    scenario = load_scenario("paper-simulation", {**COMMON, **changes})
    run = carried_run({**COMMON, **changes}, law)
    rows = [[*message, stamp] for message, stamp in messages(run, scenario.clock.control)]
    text = to_toml(scenario, comments=False)
    return run, Job("lockstep_outside.py", text, ("{rows}", law), None, rows)


def JOBS():
    return {
        "life of the drive": Job("drive_live.py", WAY),
        "faults of the drive": Job("drive_faults.py", CIRCLE),
        "faults with efforts": Job("effort_faults.py", EFFORTS),
        "loop": loop()[1],
    }


EFFORTS = """
extends = "paper-simulation"
[clock]
control = 0.05
[guard]
enabled = true
[disturbance]
std = 0.0
truncate = 3.0
"""


@pytest.fixture
def life(report):
    return report("life of the drive")


@pytest.fixture
def faults(report):
    return report("faults of the drive")


@pytest.fixture
def efforts(report):
    return report("faults with efforts")


def test_every_command_on_the_wire_is_that_of_the_run(report):
    run, _ = loop()
    found = report("loop")

    assert np.array(found["answers"]).tobytes() == sent_by(run).tobytes()
    assert (found["codes"], found["last"]) == ([0], [0.0, 0.0])


def test_it_can_be_configured_twice_and_what_a_promise_rests_on_cannot_be_set(life):
    assert life["transitions"] == [True] * 6
    assert life["set after cleanup"] == [True, True]
    assert life["set"] == [False, False]


def test_a_path_in_odom_is_driven_to_its_end_and_one_in_map_is_not(life):
    assert life["before a path"] == life["path in map"] == "no-path"
    assert life["arrived"]
    assert life["off"] < 0.02


def test_a_process_that_stood_still_ramps_from_where_it_was_and_goes_on(life):
    assert life["while frozen"] == 0
    assert all(0 <= v < 0.2 for v in life["thawed"])
    assert life["thawed"] == sorted(life["thawed"], reverse=True)
    assert life["goes on"]


def test_a_killed_node_is_silent_and_its_next_life_begins_with_zeros(life):
    assert life["after the kill"] == 0
    assert life["next life"] == 0.0
    assert life["interrupt"] == [[0.0, 0.0], 0]


def test_a_second_node_is_refused_and_a_twin_is_told_also_for_a_while_after_its_death(life):
    assert life["refused"] == 2
    assert life["twin"]
    assert any("own name" in text and "lease" in text for text in life["ghost"])


LASTING = ("missing", "in map", "of a laser", "no rotation", "NaN", "without stamp", "old",
           "repeated")  # fmt: skip
TIMEOUT = 0.1
"""Time-out of the node [s]."""
STEP = 2.0 * TICK * 1.01
"""Most that a tick may take off the speed [m/s]; fall is 2 m/s2."""


@pytest.mark.parametrize("fault", [*LASTING, "stopped"])
def test_without_odometry_that_counts_it_ramps_to_rest(faults, fault):
    found = faults["simulated" if fault == "stopped" else "real"][fault]

    assert found["falls"] <= bar(found, TIMEOUT)
    assert found["zero"] <= bar(found, TIMEOUT + 0.35)  # at most .7 m/s at 2 m/s2
    assert found["steps"] <= STEP
    assert found["there"]


PERIOD = 0.05
"""Period of the law that commands torques [s]; a sample after 1.5 periods counts as missing."""


def in_time(found, seconds):
    """Bar of the reaction time for torques: a node's ticks are periods."""
    return seconds + 2 * max(PERIOD, found["silence"]) + SLACK


BARS = {"faults of the drive": bar, "faults with efforts": in_time}
each_base = pytest.mark.parametrize("base", BARS)


@each_base
def test_where_all_is_well_diagnostics_say_so(report, base):
    said = report(base)["real"]["well"]

    assert "driving" in said or said == ["period-missed"]  # so it is on a machine that is busy


each_leap = pytest.mark.parametrize(
    "clock, fault, flag",
    [
        ("real", "pose leaps", "pose-jump"),
        ("simulated", "back", "time-back"),
        ("simulated", "ahead", "time-forth"),
    ],
)


@each_leap
def test_a_leap_brakes_at_once_and_drives_on(faults, clock, fault, flag):
    found = faults[clock][fault]

    assert found["falls"] <= bar(found, 0.0)
    assert found["steps"] <= STEP
    assert found["last"][0] > 0.1
    assert any(flag in text for text in found["said"])


def test_what_latches_waits_for_a_reset(faults):
    real = faults["real"]
    assert real["too fast"]["falls"] <= bar(real["too fast"], 0.0)
    assert real["too fast"]["steps"] <= STEP
    assert real["latched"] == [[0.0, 0.0], True]


@each_base
def test_odometry_out_of_order_is_ignored(report, base):
    found = report(base)["real"]["out of order"]
    assert found["refused"] > 5
    assert found["drives"] > 0.0
    assert not any("pose-jump" in text for text in found["said"])


@each_base
def test_a_stop_is_zero_at_once_until_a_reset(report, base):
    real = report(base)["real"]
    assert real["stop"]["zero"] <= BARS[base](real["stop"], 0.0)
    assert real["reset while stopped"] is False
    zeros, reset = real["stopped"]
    assert reset
    assert not any(zeros)
    assert real["drives again"]
    assert report(base)["simulated"]["drives again"]


@pytest.mark.parametrize("fault", [*LASTING, "stopped"])
def test_without_odometry_that_counts_there_is_no_torque(efforts, fault):
    found = efforts["simulated" if fault == "stopped" else "real"][fault]

    patience = TIMEOUT if fault == "stopped" else 1.5 * PERIOD
    assert found["zero"] <= in_time(found, patience)
    assert found["there"]


@each_leap
def test_after_a_leap_torques_are_zero_at_once_and_the_law_begins_anew(efforts, clock, fault, flag):
    found = efforts[clock][fault]

    assert found["zero"] <= in_time(found, 0.0)
    assert found["drives"] > 0.0
    assert any(flag in text for text in found["said"])


def test_with_efforts_a_rival_is_told_and_who_stood_still_or_was_killed_begins_at_0(efforts):
    real = efforts["real"]
    assert any("other publishers" in text for text in real["rival"])
    assert real["while frozen"] == real["after the kill"] == 0
    assert real["thawed"] == [0.0, 0.0]
    assert real["goes on"]
    assert real["next life"] == 0.0
    assert real["drives in it"]
    assert real["interrupt"] == [[0.0], 0]
