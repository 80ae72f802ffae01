"""Links of a promise find their entries by patterns."""

from types import SimpleNamespace

import pytest

from wmr_ctrl.core.data import data
from wmr_ctrl.results.ledger import load
from wmr_ctrl.results.promises import Link, chain

KNOWN = {name: SimpleNamespace() for name in ("a.one", "a.two", "b.one")}


def test_a_pattern_takes_in_and_one_behind_a_minus_takes_out():
    assert Link("", ("*.one", "a.*", "-b.*")).ids(KNOWN) == ["a.one", "a.two"]


def test_a_pattern_without_entry_is_an_error():
    with pytest.raises(LookupError, match=r"called c\.\*"):
        Link("", ("a.*", "c.*")).ids(KNOWN)


@pytest.mark.parametrize("name", data("wmr_ctrl.results", "promises.toml"))
def test_every_link_has_its_entries(name):
    first, assumed, *others, trusted = chain(name)

    assert [link.patterns for link in (first, assumed, trusted)] == [()] * 3
    assert all(link.ids(load().by_id()) for link in others)
