"""Parameters and ROS arguments that a node refuses: exit code 2 and a sentence."""

import pytest

from tests.ros2.conftest import OVER_DDS, Job
from tests.ros2.test_node import SCENARIO
from tests.ros2.test_scan_live import SCENARIO as SEEING

pytestmark = [pytest.mark.slow, OVER_DDS]
FILTER = """
 | the parameter scenario is not set
-p scenario:=paper-simulation | no command filter
-p scenario:=none.toml | none.toml
{} -p odometry:=maybe | must be one of none, watched, required
{} -p command_timeout:=-1.0 | command_timeout is out of its range
{} -p command_timeout:=1 | Numbers need a point
{} -p rise:=[1.0] | must have two
{} -p fall:=[0.0,1.0] | must be positive
{} -p trigger:=never | must be one of timer, command
{} -p comand_timeout:=0.5 | comand_timeout is not a parameter
{} -p other_parts:=drop | must be one of count, refuse
{} -r __ns:=/1bad | ROS 2 refuses the arguments
{} --params-file nowhere.yaml | nowhere.yaml
"""
DRIVE = """
{} | the parameter law is not set
{} -p law:=fastest | fastest
{} -p law:=pid -p reference:=path | waypoints
{} -p law:=pid -p reference:=goal | must be one of scenario, path
{} -p law:=pid -p wheels:=[left,left] | left and right
{} -p law:=pid -p jump:=[0.1] | must have two
{} -p law:=mb -p odometry_timeout:=0.01 | too short for clock.control
{} -p law:=pid -r odom:=1/odom | ROS 2 refuses the arguments
"""
LASERS = """
{} -p scans:=[scan] -p radius:=0.25 -p look:=0.001 | through which a push turns the base
{} -p scans:=[scan] -p radius:=0.0 | the disc must hold the robot
{} -p scans:=[scan] -p radius:=0.25 -p scan_pose:=[0.3,0.0,0.0] | one is at [0.3, 0.0]
{} -p scans:=[scan] -p radius:=0.25 -p no_return:=far | must be one of blind, range_max
{} -p scans:=[scan] -p radius:=0.25 -p speed_limit:=speed_limit | has no nav2_msgs
"""
SEES = "{} -p law:=kanayama | this node hears no distances"
CASES = [
    (node, scenario, *line.split(" | "))
    for node, scenario, table in (
        ("filter", SCENARIO, FILTER), ("drive", 'extends = "paper-simulation"\n', DRIVE),
        ("filter", SEEING, LASERS), ("drive", SEEING, SEES),
    )
    for line in table.strip("\n").splitlines()
]  # fmt: skip
"""Node, scenario, its parameters and words, and what is said."""


def JOBS():
    jobs = {}
    for scenario in dict.fromkeys(case[1] for case in CASES):
        given = [
            (node, words.replace("{}", "-p scenario:={}").split())
            for node, of, words, _ in CASES if of == scenario
        ]  # fmt: skip
        jobs[scenario] = Job("refusals.py", scenario, ("{rows}",), None, given)
    return jobs


@pytest.mark.parametrize("case", CASES, ids=[said for *_, said in CASES])
def test_what_cannot_be_configured_is_a_sentence(report, case):
    _, scenario, _, said = case
    code, cried = report(scenario)[[one for one in CASES if one[1] == scenario].index(case)]

    assert code == 2
    assert said in cried
    assert "Traceback" not in cried
