"""The path as C: its vectors, the simulator's bits, and a place beside the package of a law."""

import ctypes as ct

import numpy as np
import pytest
from click.testing import CliRunner

import wmr_ctrl
from tests.codegen.test_package import WARNINGS
from tests.commands import finished
from wmr_ctrl.cli import root
from wmr_ctrl.codegen.reference_package import reference_files
from wmr_ctrl.core.signals import REFERENCE
from wmr_ctrl.results import write_all
from wmr_ctrl.world.references import REFERENCES
from wmr_ctrl.world.scenario import load_scenario

POINTS = [[0.0, 0.0], [2.0, 0.5], [3.0, 2.0], [1.0, 3.0]]
ENDS = [
    {"reference.kind": "waypoints", "reference.points": POINTS, "reference.at_end": end}
    for end in ("stop", "continue", "loop")
]
FAR = {"reference.kind": "waypoints", "reference.points": [[0.0, 0.0], [1e5, 0.0]]}
KINDS = [{"reference.kind": kind} for kind in REFERENCES if kind != "waypoints"] + [*ENDS, FAR]


def scenario_of(changes):
    brief = {"clock.duration": 30.0, "changes": []}
    return load_scenario("paper-simulation-nominal", {**brief, **changes})


def built(folder, *command):
    finished(["gcc", *WARNINGS, "-O1", "-ffp-contract=off", *command, "-lm"], cwd=folder)


@pytest.mark.parametrize("k, changes", [*enumerate(KINDS)])
def test_its_vectors_hold(k, changes, tmp_path):
    """Kinds of reference are tested alternately in double and single precision."""
    write_all(reference_files(scenario_of(changes), float32=k % 2 > 0), tmp_path)
    built(tmp_path, "reference_check.c", "wmr_reference.c", "-o", "check")

    finished([tmp_path / "check"])


@pytest.mark.parametrize("changes", [KINDS[0], ENDS[2]], ids=["first", "loop"])
def test_it_has_the_bits_of_a_run(changes, tmp_path):
    scenario = scenario_of(changes)
    write_all(reference_files(scenario), tmp_path)
    built(tmp_path, "-fPIC", "-shared", "wmr_reference.c", "-o", "path.so")
    library = ct.CDLL(str(tmp_path / "path.so"))
    parameters, out = (ct.c_double * 100_000)(), (ct.c_double * 7)()
    library.wmr_reference_defaults(parameters)
    run = wmr_ctrl.simulate(scenario, "kanayama")
    rows = []
    for time in run.time:
        assert library.wmr_reference_at(parameters, ct.c_double(time), out) == 0
        rows.append(list(out))

    assert np.array_equal(np.array(rows), np.stack([run[s.name] for s in REFERENCE], axis=1))


def test_it_compiles_beside_a_law_and_its_example(wmr_folder):
    files = ("wmr_kanayama.c", "wmr_reference.c")
    built(wmr_folder, "example.c", *files, "-o", "example")
    both = '#include "wmr_reference.h"\n#include "wmr_kanayama.h"\n'
    same = "typedef char same[sizeof(wmr_reference_outputs) == 7 * sizeof(wmr_real) ? 1 : -1];\n"
    (wmr_folder / "both.c").write_text(f"{both}{same}")

    built(wmr_folder, "-c", "both.c")
    finished([wmr_folder / "example"])
    assert "wmr_reference.c" in (wmr_folder / "CMakeLists.txt").read_text()


@pytest.fixture
def wmr_folder(tmp_path):
    """Folder with the packages of a law and of the path."""
    for what in ("kanayama", "reference"):
        result = CliRunner().invoke(root, ["codegen", what, "--out", str(tmp_path)])
        assert result.exit_code == 0, result.stderr
        assert "another package" not in result.stderr
    return tmp_path
