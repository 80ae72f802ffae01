"""Every quantity that a user can set or read has a unit and a meaning."""

import dataclasses
import importlib
import re

import pytest

from tests.architecture.tree import modules
from wmr_ctrl.core import signals
from wmr_ctrl.core.signals import Signal

UNIT = re.compile(r"(1|rad|deg|%|(k?g|m|s|N|Hz|W|J)\d?)([./](k?g|m|s|N|rad)\d?)*")


def catalogue():
    listed = [value for value in vars(signals).values() if isinstance(value, Signal | tuple)]
    flat = [value if isinstance(value, tuple) else (value,) for value in listed]
    return [item for group in flat for item in group if isinstance(item, Signal)]


@pytest.mark.parametrize("signal", catalogue(), ids=lambda signal: signal.name)
def test_signals_have_si_units_and_a_meaning(signal):
    assert signal.meaning
    assert len(signal.units) == len(signal.elements) == signal.size
    assert all(UNIT.fullmatch(unit) for unit in signal.units), signal.units


def section_fields():
    """Fields of every dataclass of scenarios and gains that were declared as quantities."""
    found = []
    for module in modules():
        if module.room not in {"world", "control"} or "quantity(" not in module.text:
            continue
        loaded = vars(importlib.import_module(module.name)).values()
        own = [item for item in loaded if isinstance(item, type) and item.__module__ == module.name]
        for item in filter(dataclasses.is_dataclass, own):
            found += [
                (f"{module.name}.{item.__name__}", f.name, f) for f in dataclasses.fields(item)
            ]
    return found


def test_fields_of_scenarios_and_gains_have_units_and_comments():
    listed = [(owner, name, f) for owner, name, f in section_fields() if f.metadata]
    bare = [
        f"{owner}.{name}"
        for owner, name, f in listed
        if not f.metadata.get("doc") or "unit" not in f.metadata
    ]

    assert len(listed) > 20
    assert bare == []
