"""The registry of references."""

import pytest

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.world.references.curves import CIRCLE, Line
from wmr_ctrl.world.references.registry import OURS, REFERENCES, ReferenceRegistry


def test_an_entry_is_found_by_the_name_that_it_gives_itself_and_by_its_section():
    assert len(REFERENCES) == len(set(REFERENCES)) > 3
    assert all(entry.name == name for name, entry in REFERENCES.items())
    assert REFERENCES.of(Line()) is REFERENCES["line"]


def test_a_name_of_ours_is_nobody_elses(monkeypatch):
    where = "wmr_ctrl.world.references.registry.loaded"
    monkeypatch.setattr(where, lambda *_: (CIRCLE,))

    assert CIRCLE in OURS
    with pytest.raises(ArgumentError, match="two references are called 'circle'"):
        list(ReferenceRegistry())
