"""Settings for all tests: a build cache of their own, no windows, repeatable random examples.

Libraries are compiled at the level -O1, which takes half the time of -O3 and gives the same bits:
tests/bits compares builds at -O2 and -O3 with them, for every law.
"""

from __future__ import annotations

import os

import pytest
from hypothesis import HealthCheck, settings

os.environ.setdefault("MPLBACKEND", "Agg")
os.environ.setdefault("WMR_CTRL_OPTIMIZE", "1")
settings.register_profile(
    "project",
    deadline=None,
    derandomize=True,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow],  # how busy the machine is, is no one's fault
)
settings.load_profile("project")


def pytest_configure(config: pytest.Config) -> None:
    """Keep compiled kernels in pytest's own cache folder, so that HOME stays untouched."""
    cache = getattr(config, "cache", None)
    if cache is not None:
        os.environ.setdefault("WMR_CTRL_CACHE", str(cache.mkdir("wmr_ctrl")))
