"""What ``wmr-ctrl bench`` reports: ratios by name, medians of rounds, a table; and the limits."""

import json
import os
import sys
from functools import partial

import pytest

from benchmarks import bench
from benchmarks.timing import Candidate, Timing
from wmr_ctrl import api

NAMED = {
    "nn_step_vs_hand_c", "mb_step_vs_hand_c", "nn_step_numpy_vs_native", "nn_step_vm_vs_native",
    "closed_loop_nn_vs_hand_c", "closed_loop_numpy_vs_native",
    "batch_nn_per_core_vs_scalar_hand_c", "nn_call_from_python_vs_hand_c",
    "fmu_plant_step_vs_empty_call",
}  # fmt: skip


def timing(name, ratios):
    return Timing(name, 100.0, ratios[1], ratios[0], ratios[2], ratios)


def test_ratios_have_their_names_and_come_from_within_rounds():
    found = {"nn": timing("nn", (1.0, 4.0, 3.0)), "nn_hand": timing("nn_hand", (1.0, 2.0, 3.0))}
    result = bench.summary(found, {})

    assert set(result["ratios"]) >= NAMED
    assert result["ratios"]["nn_step_vs_hand_c"] == 1.0
    assert result["ratios"]["fmu_plant_step_vs_empty_call"] is None
    assert json.loads(json.dumps(result)) == result


def fails():
    raise OSError("no disk.\nThe second sentence")


@pytest.mark.slow
def test_what_cannot_be_measured_is_a_line_with_its_reason(monkeypatch):
    """One candidate cannot be built, one raises when it runs, and one ends its process."""
    works = partial(Candidate, list, 1)
    groups = (
        {"nn_hand": fails, "nn": works, "nn_vm": works, "nn_numpy": partial(Candidate, fails, 1)},
        {"nn_loop_hand": works, "nn_loop": partial(Candidate, partial(os._exit, 3), 1)},
    )
    monkeypatch.setattr(bench, "GROUPS", groups)
    result = bench.run_bench()
    lines = {line.split()[0]: line for line in bench.table(result).splitlines() if line}

    assert result["ratios"]["nn_step_vm_vs_native"] is not None
    assert lines["nn_step_vs_hand_c"].endswith("not measured: OSError: no disk")
    assert lines["nn_step_numpy_vs_native"].endswith("not measured: OSError: no disk")
    assert "not measured: BrokenProcessPool: " in lines["closed_loop_nn_vs_hand_c"]


def test_the_interface_measures_with_this_folder_and_leaves_the_path_alone(monkeypatch):
    measured = bench.summary({"nn": timing("nn", (1.0, 1.0, 1.0))}, {})
    monkeypatch.setattr(bench, "run_bench", lambda progress: measured)
    before = [*sys.path]
    report = api.bench()

    assert report == {**measured, "text": bench.table(measured)}
    assert sys.path == before
