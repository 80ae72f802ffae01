"""The text of the filter as a node in C: its settings, and options that cannot be compiled in."""

import json
import os
import re

import pytest
from click.testing import CliRunner

from tests.commands import finished, flat
from tests.ros2.conftest import OVER_DDS
from tests.tables import cases, changes
from wmr_ctrl.cli.root import root
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.ros2.c_node import GIVEN, NAME, NodeSettings, node_files, node_settings, write_node
from wmr_ctrl.ros2.parameters import FILTER
from wmr_ctrl.world.scenario import load_scenario

STATED = changes("filter.kind = 'clip'; filter.gain = [0.9, 1.1]; filter.d = [0.05, 0.05]")
WORDS = {"stamped": "true", "odometry": "watched", "trigger": "timer"}


def word(name):
    """NAME=VALUE of a parameter's default."""
    default = FILTER[name].default
    value = json.dumps(default) if isinstance(default, list) else str(default)
    return f"{name}={WORDS.get(name, value)}"


def test_defaults_are_those_of_the_node_in_python():
    assert node_settings([word(name) for name in GIVEN]) == node_settings([]) == NodeSettings()


def test_settings_are_compiled_in():
    given = ["odometry=required", "stamped=false", "base_frame=base", "trigger=command",
             "command_timeout=0.5", "rise=[0.5, 1]"]  # fmt: skip
    files = node_files(load_scenario("paper-simulation", STATED), node_settings(given))

    assert "#define WMR_COMMAND_TIMEOUT INT64_C(500000000)" in files["gate_numbers.h"]
    for line in ('WMR_BASE_FRAME "base"', "WMR_STAMPED 0", "WMR_AT_ONCE 1"):
        assert f"#define {line}\n" in files["node_settings.h"]
    assert {"package.xml", "CMakeLists.txt", "README.md"} <= set(files)


@pytest.mark.parametrize("how", ["CMakeLists.txt", "README.md"])
def test_each_source_is_compiled(how):
    files = node_files(load_scenario("paper-simulation", STATED), NodeSettings())

    assert {name for name in files if name.endswith(".c")} == set(
        re.findall(r"(?<= )\w+\.c(?=[ )])", files[how])
    )


def test_a_frame_is_a_text_of_c_whatever_is_in_it():
    frame = 'a"b\\c?\u00e9'
    files = node_files(load_scenario("paper-simulation", STATED), NodeSettings(frame=frame))
    (text,) = re.findall(r'WMR_BASE_FRAME "(.*)"', files["node_settings.h"])

    parts = re.findall(r"\\(\d{3})|(.)", text)
    assert bytes(int(octal, 8) if octal else ord(plain) for octal, plain in parts) == frame.encode()


@pytest.mark.parametrize(
    "given, said",
    cases("""
        speed=1 | not a parameter that can be compiled
        scenario=mine.toml | not a parameter that can be compiled
        rise=[1.0] | must be like its default
        rise=fast | must be like its default
        command_timeout=[1.0] | must be like its default
        stamped=1 | must be like its default
        command_timeout=-1 | out of its range
        odometry_timeout=61 | out of its range
        command_timeout=NaN | out of its range
        excess=[0, 1] | must be positive
        odometry=maybe | must be one of
        trigger=never | must be one of
    """),
)
def test_what_cannot_be_compiled_in_is_a_sentence(given, said):
    with pytest.raises(ArgumentError, match=said):
        node_settings([given])


@pytest.mark.parametrize(
    "words, said",
    cases("""
        nn --ros2 | command filter
        filter --ros2 --float32 | double precision
        filter --param stamped=false | it works only with --ros2
    """),
)
def test_options_that_do_not_go_together_are_refused(tmp_path, words, said):
    done = CliRunner().invoke(root, ["codegen", *words.split(), "--out", str(tmp_path / "out")])

    assert done.exit_code == 2
    assert said in flat(done.output)
    assert not (tmp_path / "out").exists()


SPEED_LIMIT = """
#include <rosidl_runtime_c/message_type_support_struct.h>
typedef struct {
    double speed_limit;
    bool percentage;
} nav2_msgs__msg__SpeedLimit;
bool nav2_msgs__msg__SpeedLimit__init(nav2_msgs__msg__SpeedLimit *message);
const rosidl_message_type_support_t *ROSIDL_TYPESUPPORT_INTERFACE__MESSAGE_SYMBOL_NAME(
    rosidl_typesupport_c, nav2_msgs, msg, SpeedLimit)(void);
"""
"""Replacement for nav2's header, for which there is no wheel."""


@pytest.mark.slow
@OVER_DDS
def test_a_node_that_hears_nav2_compiles_with_its_message(ros, tmp_path):
    scenario = load_scenario("paper-simulation", {**STATED, "filter.changing": True})
    write_node(tmp_path, scenario, node_settings(["speed_limit=speed_limit"]))
    header = tmp_path / "nav2_msgs" / "msg" / "speed_limit.h"
    header.parent.mkdir(parents=True)
    header.write_text(SPEED_LIMIT, "utf-8")
    places = [f"-I{path}" for path in (tmp_path, *(ros.parent.parent / "include").iterdir())]
    flags = ["-std=gnu11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only"]
    finished(["cc", *flags, *places, *(path.name for path in tmp_path.glob("*.c"))], cwd=tmp_path)

    assert "find_package(nav2_msgs REQUIRED)" in (tmp_path / "CMakeLists.txt").read_text("utf-8")


@pytest.mark.slow
@OVER_DDS
def test_command_of_the_readme_links_as_written(ros, tmp_path):
    write_node(tmp_path, load_scenario("paper-simulation", STATED))
    readme = (tmp_path / "README.md").read_text("utf-8")
    (command,) = re.findall(r"```sh\n(.*?)```", readme, re.S)
    environment = {**os.environ, "PREFIX": str(ros.parent.parent)}
    finished(["bash", "-e", "-c", command], cwd=tmp_path, env=environment)
    assert (tmp_path / NAME).is_file()
