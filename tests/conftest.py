"""Settings for all tests: a build cache of their own, no windows, repeatable random examples."""

from __future__ import annotations

import os

import pytest
from hypothesis import HealthCheck, settings

os.environ.setdefault("MPLBACKEND", "Agg")
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
