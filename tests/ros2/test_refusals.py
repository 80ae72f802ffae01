"""Parameters and words of ROS that a node cannot take: exit code 2 and a sentence."""

import pytest

from tests.ros2.conftest import OVER_DDS, Job
from tests.ros2.test_node import SCENARIO
from tests.ros2.test_scan_live import SCENARIO as SEEING

pytestmark = [pytest.mark.slow, OVER_DDS]
HERE = "scenario:={}"
LASER = [HERE, "scans:=[scan]"]
SEES = [*LASER, "radius:=0.25"]
FILTER = [
    ([], "the parameter scenario is not set"),
    (["scenario:=paper-simulation"], "no command filter"),
    (["scenario:=none.toml"], "none.toml"),
    ([HERE, "odometry:=maybe"], "must be one of none, watched, required"),
    ([HERE, "command_timeout:=-1.0"], "command_timeout is out of its range"),
    ([HERE, "command_timeout:=1"], "Numbers need a point"),
    ([HERE, "rise:=[1.0]"], "must have two"),
    ([HERE, "fall:=[0.0, 1.0]"], "must be positive"),
    ([HERE, "trigger:=never"], "must be one of timer, command"),
    ([HERE, "comand_timeout:=0.5"], "comand_timeout is not a parameter"),
    ([HERE, "other_parts:=drop"], "must be one of count, refuse"),
    ([HERE, "-r", "__ns:=/1bad"], "ROS 2 refuses the arguments"),
    ([HERE, "--params-file", "nowhere.yaml"], "nowhere.yaml"),
]
DRIVE = [
    ([HERE], "the parameter law is not set"),
    ([HERE, "law:=fastest"], "fastest"),
    ([HERE, "law:=pid", "reference:=path"], "waypoints"),
    ([HERE, "law:=pid", "reference:=goal"], "must be one of scenario, path"),
    ([HERE, "law:=pid", "wheels:=[left, left]"], "left and right"),
    ([HERE, "law:=pid", "jump:=[0.1]"], "must have two"),
    ([HERE, "law:=mb", "odometry_timeout:=0.01"], "too short for clock.control"),
    ([HERE, "law:=pid", "-r", "odom:=1/odom"], "ROS 2 refuses the arguments"),
]
LASERS = [
    ([*SEES, "look:=0.001"], "through which a push turns the base"),
    ([*LASER, "radius:=0.0"], "the disc must hold the robot"),
    ([*SEES, "scan_pose:=[0.3, 0.0, 0.0]"], "one is at [0.3, 0.0]"),
    ([*SEES, "no_return:=far"], "must be one of blind, range_max"),
    ([*SEES, "speed_limit:=speed_limit"], "has no nav2_msgs"),
]
CASES = [
    *(("filter", SCENARIO, *case) for case in FILTER),
    *(("drive", 'extends = "paper-simulation"\n', *case) for case in DRIVE),
    *(("filter", SEEING, *case) for case in LASERS),
    ("drive", SEEING, [HERE, "law:=kanayama"], "this node hears no distances"),
]
"""Node, scenario, its parameters and words, and what is said."""


def words_of(settings):
    """Words of a command line: each setting is a parameter, until one begins with a dash."""
    end = next((k for k, word in enumerate(settings) if word.startswith("-")), len(settings))
    return [part for word in settings[:end] for part in ("-p", word)] + settings[end:]


def JOBS():
    jobs = {}
    for scenario in dict.fromkeys(case[1] for case in CASES):
        given = [[node, words_of(settings)] for node, of, settings, _ in CASES if of == scenario]
        jobs[scenario] = Job("refusals.py", scenario, ("{rows}",), None, given)
    return jobs


@pytest.mark.parametrize("case", CASES, ids=[said for *_, said in CASES])
def test_what_cannot_be_configured_is_a_sentence(report, case):
    _, scenario, _, said = case
    code, cried = report(scenario)[[one for one in CASES if one[1] == scenario].index(case)]

    assert code == 2
    assert said in cried
    assert "Traceback" not in cried
