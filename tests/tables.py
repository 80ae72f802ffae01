"""Cases of tests as text: changes of a scenario as `--set` takes them, and tables of cases."""

import re

import pytest

from wmr_ctrl.world.scenario import parse_assignments


def changes(text):
    """Overrides of a scenario: ``KEY = VALUE`` in TOML, a line each or a semicolon between."""
    return parse_assignments(part for part in re.split(r"[;\n]", text) if part.strip())


def cases(text):
    """Cases of a parametrised test: a line each, with bars between values; ``| slow`` marks one."""
    found = []
    for line in text.strip().splitlines():
        values = [value.strip() for value in line.split(" | ")]
        slow = values[-1] == "slow"
        marks = pytest.mark.slow if slow else ()
        found.append(pytest.param(*(values[:-1] if slow else values), marks=marks))
    return found
