"""Every name in docs/reference/stable.txt still exists."""

import pytest

from tests.packaging import interface


@pytest.fixture(scope="module")
def present():
    return set(interface.lines())


@pytest.mark.slow
def test_nothing_that_is_promised_is_gone(present):
    gone = [line for line in interface.promised() if line not in present]

    assert gone == [], "see docs/reference/stable.md: it goes in two steps, with a major version"


@pytest.mark.slow
def test_the_list_is_in_order_and_covers_every_kind(present):
    listed = interface.promised()

    assert listed == sorted(set(listed))
    assert {line.partition(":")[0] for line in present} == {x.partition(":")[0] for x in listed}


@pytest.mark.slow
def test_no_number_of_a_run_has_two_names(present):
    """A figure is under its own key, or under `figures`."""
    under = {line.partition(": ")[2] for line in present if line.startswith("run --json")}
    keys = {item.key for item in interface.FIGURES if item.key}

    assert keys <= under
    assert {item.name for item in interface.FIGURES if item.name in under} <= keys
