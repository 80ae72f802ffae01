"""Every quantity that a user can set or read has a unit and a meaning."""

import re

import pytest

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
