"""Data in files beside the modules."""

import pytest

from wmr_ctrl.core.data import data, with_tuples


def test_a_table_is_read_beside_its_module_and_its_arrays_become_tuples():
    names = data("wmr_ctrl.world.robot_files", "names.toml")

    assert "controller" in names
    assert with_tuples({"a": [1, 2], "b": "x"}) == {"a": (1, 2), "b": "x"}
    with pytest.raises(FileNotFoundError):
        data("wmr_ctrl.world.robot_files", "nothing.toml")
