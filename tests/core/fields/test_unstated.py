"""Values that nobody stated."""

import pytest

from wmr_ctrl.core.fields.unstated import Unknown, Unstated, derived, unknown


@pytest.mark.parametrize("value", [2.5, (1.0, 2.0)])
def test_they_are_their_numbers_and_only_some_are_not_known(value):
    follows, placeholder = derived(value), unknown(value)

    assert follows == placeholder == value
    assert isinstance(follows, Unstated)
    assert not isinstance(follows, Unknown)
    assert isinstance(placeholder, Unknown)
    assert not isinstance(value, Unstated)
