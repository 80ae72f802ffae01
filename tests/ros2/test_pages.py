"""The how-to pages: nodes start with the commands and files on the pages."""

import re
import shlex

import pytest

from tests.docs.pages import DOCS, Page
from tests.ros2.conftest import OVER_DDS, Job

START = "-m wmr_ctrl.ros2 "
pytestmark = [pytest.mark.slow, OVER_DDS]


def given():
    """Files of both pages, and the words of their commands; behind nav2 those of the filter,
    too.
    """
    files, commands = {}, []
    for name in ("ros2.md", "drive_base.md"):
        page = Page(DOCS / "howto" / name)
        files |= {block.file: block.text for block in page.blocks if block.file}
        written = [line for block in page.blocks for line, _ in block.commands if START in line]
        commands += [shlex.split(line.partition(START)[2]) for line in written]
        (remap,) = re.findall(r"`(-r cmd_vel_in:=\S+)`", page.text) or [""]
        commands += [[*commands[-1], *shlex.split(remap)]] if remap else []
    return {"files": files, "commands": commands}


def JOBS():
    return {"commands of the pages": Job("as_written.py", "", ("{rows}",), None, given())}


def test_each_command_starts_a_node_that_sends_zeros_and_ends(report):
    commands, found = given()["commands"], report("commands of the pages")

    assert [words[0] for words in commands] == ["filter", "filter", "drive"]
    for words, (velocities, _, code) in zip(commands, found, strict=True):
        assert velocities == [[0.0, 0.0]] * 3, words
        assert code == 0
    assert [heard for _, heard, _ in found] == [0, 1, 0]
