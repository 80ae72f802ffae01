"""Outputs for other tools, by their names."""

import pytest

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.export.outputs import read_by, write_output


def test_an_output_takes_the_options_of_what_writes_it(tmp_path):
    assert {"law", "fmi", "target"} <= set(read_by("plant"))
    assert "law" in read_by("simulink")
    assert "fmi" not in read_by("modelica")
    with pytest.raises(ArgumentError, match="the output 'modelica' does not use fmi"):
        write_output("modelica", {"fmi": "2", "out": tmp_path})
    assert list(tmp_path.iterdir()) == []
