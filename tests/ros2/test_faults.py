"""The table of faults names existing tests that use nodes over real DDS."""

import inspect
from importlib import import_module
from pathlib import Path

import pytest

LINES = Path(__file__).with_name("faults.txt").read_text("utf-8").splitlines()
ROWS = [line for line in LINES if line and not line.startswith("#")]
NAMED = [line.split() for line in ROWS if line.startswith(" ")]


@pytest.mark.parametrize("module, name", NAMED)
def test_a_named_test_is_there_and_runs_over_dds(module, name):
    home = import_module(f"tests.ros2.{module}")
    asked = set(inspect.signature(getattr(home, name)).parameters)

    assert asked & {"report", "seen", "live", "life", "faults", "efforts", "kind"}
    assert hasattr(home, "JOBS")


def test_each_fault_has_a_test():
    faults = [place for place, line in enumerate(ROWS) if not line.startswith(" ")]

    assert len(faults) > 20
    assert all(ROWS[place + 1].startswith(" ") for place in faults)
