"""Tests of the rigid body need the extra `physics`; without it they are not collected."""

from importlib.util import find_spec

collect_ignore_glob = [] if find_spec("mujoco") else ["test_*.py"]
