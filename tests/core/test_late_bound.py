"""Functions of higher layers are imported on first use."""

import pytest

from wmr_ctrl.core.late_bound import HOMES, late_bound


@pytest.mark.parametrize("name", HOMES)
def test_each_is_in_its_home(name):
    found = late_bound(name)

    assert (found.__name__, found.__module__) == (name, HOMES[name])


def test_others_are_not_reached():
    with pytest.raises(KeyError):
        late_bound("simulate")
