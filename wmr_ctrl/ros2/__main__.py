"""``python -m wmr_ctrl.ros2 filter --ros-args -p scenario:=mine.toml``."""

import signal
import sys

NODES = ("filter", "drive")
USAGE = """\
usage: python -m wmr_ctrl.ros2 NODE --ros-args -p scenario:=FILE.toml [-p NAME:=VALUE ...]
       python -m wmr_ctrl.ros2 prepare FILE.toml [-p NAME:=VALUE ...]

NODE is one of
  filter  limits the commands (v, omega) of somebody else, with the scenario's command filter
  drive   drives the scenario's path with one of its laws

prepare compiles what both need, so that they configure at once; no ROS 2 is needed for it.

The parameters of each node are in docs/howto/ros2.md.
"""


def main() -> int:
    """Run the named node; returns 0, or 2 with a message if it cannot run."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    try:
        return _run(sys.argv[1:])
    except KeyboardInterrupt:  # before there was a node
        return 0


def _run(given: list[str]) -> int:
    if given[:1] in (["--help"], ["-h"]):
        sys.stdout.write(USAGE)
        return 0
    if given[:1] == ["prepare"]:
        return _prepare([word for word in given[1:] if word not in ("-p", "--ros-args")])
    if not given or given[0] not in NODES:
        sys.stderr.write(f"error: name a node: python -m wmr_ctrl.ros2 {' | '.join(NODES)}\n")
        return 2
    try:
        import rclpy  # noqa: F401  # told before anything else is loaded
    except ImportError:
        sys.stderr.write(
            "error: ROS 2 was not found (no module rclpy). Source a ROS 2 installation and use its "
            "Python: python3 -m venv --system-site-packages, and install wmr_ctrl there.\n"
        )
        return 2
    from .drive_node import DriveNode
    from .filter_node import FilterNode
    from .spin import spin

    return spin(FilterNode if given[0] == "filter" else DriveNode, given[1:])


def _prepare(words: list[str]) -> int:
    from wmr_ctrl.core.errors import WmrError

    from .prepare import prepare

    try:
        if not words:
            raise WmrError("name a scenario: python -m wmr_ctrl.ros2 prepare FILE.toml.")
        for ready in prepare(words[0], words[1:]):
            sys.stdout.write(f"ready: {ready}\n")
    except WmrError as error:
        sys.stderr.write(f"error: {' '.join(str(error).split())}\n")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
