"""The package for colcon: built from wheels, found by the ament index, its executables run."""

import os
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree

import pytest
import yaml

from tests.commands import finished
from tests.ros2.conftest import OVER_DDS, ROOT, with_python
from tests.ros2.test_node import SCENARIO
from wmr_ctrl.control.filter.gate import ODOMETRY_USES
from wmr_ctrl.ros2.c_node import NAME, write_node
from wmr_ctrl.ros2.parameters import DRIVE, FILTER
from wmr_ctrl.world.scenario import load_scenario

PACKAGE = ROOT / "ros" / "wmr_ctrl_ros"
TABLES = {"filter": FILTER, "drive": DRIVE}
NO_DEFAULT = {"scenario", "law", "autostart"}


@pytest.mark.parametrize("node", TABLES)
def test_shipped_parameters_are_all_that_have_defaults_and_those(node):
    document = yaml.safe_load((PACKAGE / "config" / f"{node}.yaml").read_text("utf-8"))

    assert list(document) == ["/**"]  # a node's name would be ignored in a namespace
    expected = {key: item.default for key, item in TABLES[node].items() if key not in NO_DEFAULT}
    assert document["/**"]["ros__parameters"] == expected


def test_uses_of_odometry_are_those_of_the_gate():
    assert tuple(FILTER["odometry"].choices) == ODOMETRY_USES


@pytest.mark.parametrize("node", TABLES)
def test_launch_files_name_what_there_is(node):
    (launched,) = ElementTree.parse(PACKAGE / "launch" / f"{node}.launch.xml").iter("node")

    assert (launched.get("pkg"), launched.get("exec")) == ("wmr_ctrl_ros", node)
    assert launched.get("name") == f"wmr_{node}"
    named = {item.get("name") for item in launched.iter("param")} - {None}
    assert named == NO_DEFAULT & set(TABLES[node]) - {"autostart"} | {"base_frame"}


@pytest.fixture(scope="module")
def installed(ros, tmp_path_factory):
    """Prefix that colcon installs into, with the files that ROS packages need."""
    space = tmp_path_factory.mktemp("space")
    shutil.copytree(PACKAGE, space / "src" / PACKAGE.name)
    paths = f"{ros.parent}{os.pathsep}{os.environ['PATH']}"
    finished(
        [ros, "-m", "colcon", "build"],
        cwd=space,
        env={**os.environ, "PATH": paths, "COLCON_LOG_PATH": str(space / "log")},
        timeout=900,
    )
    return space / "install" / PACKAGE.name


@pytest.mark.slow
@OVER_DDS
def test_the_ament_index_finds_the_package(ros, installed):
    asked = "from ament_index_python import get_package_share_directory as d; print(d('{}'))"
    env = {**os.environ, "AMENT_PREFIX_PATH": installed}
    done = finished([ros, "-c", asked.format(PACKAGE.name)], env=env)
    share = installed / "share" / PACKAGE.name
    assert done.stdout.strip() == str(share)
    assert {path.name for path in share.glob("*/*")} >= {
        "filter.launch.xml", "drive.launch.xml", "filter.yaml", "drive.yaml", "wmr_ctrl.json",
    }  # fmt: skip


@pytest.mark.slow
@OVER_DDS
def test_an_executable_finds_the_environment_and_reads_the_parameters(
    ros, environment, installed, tmp_path
):
    """The node runs in a namespace; a wrong value of the file is refused, so the file was read."""
    shipped = (installed / "share" / PACKAGE.name / "config" / "filter.yaml").read_text("utf-8")
    (tmp_path / "wrong.yaml").write_text(shipped.replace("watched", "maybe", 1), "utf-8")
    (tmp_path / "base.toml").write_text(SCENARIO, "utf-8")
    site = next((installed / "lib").glob("python*/site-packages"))
    given = ["--ros-args", "--params-file", tmp_path / "wrong.yaml", "-r", "__ns:=/robot1",
             "-p", f"scenario:={tmp_path / 'base.toml'}"]  # fmt: skip
    program = installed / "lib" / PACKAGE.name / "filter"
    finds = {"WMR_CTRL_PYTHON": str(ros), "PYTHONPATH": str(site)}
    done = subprocess.run(
        [program, *given], env={**environment, **finds},
        capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip

    assert program.read_text("utf-8").startswith("#!/usr/bin/env python3")
    assert done.returncode == 2
    assert "odometry = 'maybe' must be one of" in done.stderr


@pytest.mark.slow
@OVER_DDS
@pytest.mark.parametrize(
    "python, said", [("", "wmr_ctrl was not found"), ("/nowhere/python", "cannot be run")]
)
def test_without_an_environment_a_sentence_says_so(installed, python, said):
    site = next((installed / "lib").glob("python*/site-packages"))
    plain = {"PATH": "/usr/bin:/bin", "PYTHONPATH": str(site), "WMR_CTRL_PYTHON": python}
    script = "from wmr_ctrl_ros.nodes import run_drive; raise SystemExit(run_drive())"
    done = subprocess.run(
        ["python3", "-c", script],
        cwd=site, env=plain, capture_output=True, text=True, check=False,
    )  # fmt: skip

    assert done.returncode == 2
    assert said in done.stderr


@pytest.mark.slow
@OVER_DDS
def test_the_node_in_c_is_a_package_of_ament_cmake(ros, environment, tmp_path):
    """Colcon builds it unchanged.  When started, it ends at an unknown parameter."""
    (tmp_path / "base.toml").write_text(SCENARIO, "utf-8")
    write_node(tmp_path / "src" / NAME, load_scenario(tmp_path / "base.toml"))
    prefix = str(ros.parent.parent)
    paths = {"PATH": f"{ros.parent}{os.pathsep}{os.environ['PATH']}", "CMAKE_PREFIX_PATH": prefix}
    logs = {"AMENT_PREFIX_PATH": prefix, "COLCON_LOG_PATH": str(tmp_path / "log")}
    found = {**os.environ, **paths, **logs}
    linked = f"-DCMAKE_EXE_LINKER_FLAGS={' '.join(with_python())}"
    command = [ros, "-m", "colcon", "build", "--cmake-args", linked]
    finished(command, cwd=tmp_path, env=found, timeout=900)
    program = tmp_path / "install" / NAME / "lib" / NAME / NAME
    started = subprocess.run(
        [ros, "-c", "import os, sys; os.execv(sys.argv[1], sys.argv[1:])", program,
         "--ros-args", "-p", "rise:=[9.0, 9.0]"],
        env=environment, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip

    assert started.returncode == 2
    assert "the parameter rise cannot be set" in started.stderr
