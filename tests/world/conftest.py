"""Toys as another package would register them."""

import pytest

from tests.world import toys
from wmr_ctrl.world.references.registry import REFERENCES
from wmr_ctrl.world.registry import EFFECTS


@pytest.fixture
def toy_world(monkeypatch):
    """Both registries with the toys."""
    monkeypatch.setitem(EFFECTS.__dict__, "plugins", toys.EFFECTS)
    monkeypatch.setitem(REFERENCES.__dict__, "plugins", (toys.CLOTHOID,))
