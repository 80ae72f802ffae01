"""Saving and loading: nothing is lost, and a file that is not a run says so in one paragraph."""

import csv
import json
import math

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.equal_runs import runs_equal
from tests.results.conftest import build
from wmr_ctrl.core.errors import ResultFileError
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.results import Monitor, load_run
from wmr_ctrl.results.formats import save_run

SUFFIXES = [".npz", ".csv"]
NASTY = [math.nan, math.inf, -math.inf, -0.0, 5e-324, 1.7976931348623157e308, 0.1, 1 / 3]

# The folder of a test is reused by all its examples, each of which writes its file anew.
reusing_folder = settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
    max_examples=15,
)


LOST = Monitor((math.inf, math.nan), 2, (0.001, 2), (0.05, 1), "non-finite")


def saved(run, folder, suffix):
    path = folder / f"run{suffix}"
    save_run(run, path)
    return path


def refused(path):
    """True if loading is refused in one paragraph that names the file; any other error fails the
    test.
    """
    try:
        load_run(path)
    except ResultFileError as error:
        message = str(error)
    else:
        return False
    assert "\n" not in message
    assert path.name in message
    return True


@pytest.mark.parametrize("suffix", SUFFIXES)
@reusing_folder
@given(
    x=arrays(np.float64, 20, elements=st.floats() | st.sampled_from(NASTY)),
    e=arrays(np.float64, (20, 3), elements=st.floats() | st.sampled_from(NASTY)),
    words=st.dictionaries(st.text(), st.text(), max_size=3),
)
@pytest.mark.slow_but(".npz")
def test_a_saved_run_loads_back_equal(tmp_path, suffix, x, e, words):
    run = build(duration=0.2, x=x, e=e, provenance=words)
    loaded = load_run(saved(run, tmp_path, suffix))

    assert runs_equal(loaded, run)
    assert (loaded.settings, loaded.signals) == (run.settings, run.signals)
    assert dict(loaded.provenance) == words
    assert np.array_equal(loaded["e"], e, equal_nan=True)
    assert np.array_equal(np.signbit(loaded["x"][x == 0]), np.signbit(x[x == 0]))


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("rows", [0, 1, 5])
def test_a_run_that_ended_early_loads_back_equal(tmp_path, suffix, rows):
    labels = {"guard": True, "seed": 2**70, "law": "my, law", "scenario": 'a "b"\n# c é'}
    extra = (Signal("m_hat", "kg", "mass, as estimated", 2), Signal("Größe", "m", "a, b"))
    run = build(rows=rows, monitor=LOST, labels=labels, extra=extra)
    loaded = load_run(saved(run, tmp_path, suffix))

    assert runs_equal(loaded, run)
    assert (loaded.seed, loaded.outcome) == (2**70, "non-finite")
    assert repr(loaded.monitor) == repr(LOST)


@pytest.mark.parametrize("suffix", [*SUFFIXES, ".NPZ", ".Csv"])
def test_equal_runs_give_equal_bytes_whatever_the_case_of_the_suffix(tmp_path, suffix):
    first = saved(build(x=1.0), tmp_path, suffix).read_bytes()
    again = saved(build(x=1.0), tmp_path, suffix)

    assert again.read_bytes() == first
    assert runs_equal(load_run(again), build(x=1.0))


def test_other_readers_find_names_units_and_numbers_in_the_csv(tmp_path):
    run = build(x=np.arange(100.0) / 3, e=[1.0, 2.0, 3.0])
    lines = saved(run, tmp_path, ".csv").read_text().splitlines()
    comments = [line[2:] for line in lines if line.startswith("# ")]
    header, *rows = csv.reader(lines[len(comments) :])

    assert json.loads("\n".join(comments))["settings"]["duration"] == 1.0
    assert header[:2] == ["t [s]", "x [m]"]
    assert {"e[3] [rad]", "v_c0[2] [rad/s]"} < set(header)
    assert [float(row[header.index("x [m]")]) for row in rows] == run["x"].tolist()


# -- files that are no runs ---------------------------------------------------------------


@pytest.mark.parametrize("suffix", SUFFIXES)
@reusing_folder
@given(part=st.floats(0, 1))
@example(part=1.0)
def test_a_file_cut_anywhere_is_refused(tmp_path, suffix, part):
    path = saved(build(duration=0.05, x=1 / 3), tmp_path, suffix)
    whole = path.read_bytes()
    path.write_bytes(whole[: min(int(part * len(whole)), len(whole) - 1)])

    assert refused(path)


@pytest.mark.parametrize("suffix", SUFFIXES)
@reusing_folder
@given(part=st.floats(0, 1, exclude_max=True), flip=st.integers(1, 255))
def test_a_flipped_byte_is_refused_or_harmless(tmp_path, suffix, part, flip):
    """A changed digit in a table may be another valid number, which is harmless."""
    run = build(duration=0.05, x=1 / 3)
    path = saved(run, tmp_path, suffix)
    data = bytearray(path.read_bytes())
    data[int(part * len(data))] ^= flip
    path.write_bytes(data)

    if not refused(path):
        assert load_run(path).rows == 5
        assert suffix == ".csv" or runs_equal(load_run(path), run)


@pytest.mark.parametrize(
    "old, new",
    [
        (b"run, version 1", b"run, version 2"),
        (b'"rows": 5', b'"rows": 4'),
        (b'"outcome": "completed"', b'"outcome": "diverged"'),
        (b'"guard": false', b'"guard": "false"'),
        (b'"seed": 0', b'"seed": 0.5'),
        (b'"law": "nn"', b'"law": 3'),
        (b'"control": 0.01', b'"control": "fast"'),
        (b'"control": 0.01', b'"control": -0.01'),
        (b'"violations": 0', b'"violations": 1'),
        (b'"provenance": {}', b'"provenance": []'),
        (b"x [m]", b"x [km]"),
        (b"\n0.01,", b"\n0.02,"),
        (b"\n0.01,", b"\n0.01,,"),
        (b"\n0.01,", b"\nlate,"),
        (b'"size": 1', b'"si\\nze": 1'),
    ],
)
def test_a_csv_edited_into_a_contradiction_is_refused(tmp_path, old, new):
    path = saved(build(duration=0.05), tmp_path, ".csv")
    data = path.read_bytes()
    assert old in data
    path.write_bytes(data.replace(old, new, 1))

    assert refused(path)


@pytest.mark.parametrize("name", ["run", "run.txt", "run.npz.gz", ".npz"])
def test_an_unknown_suffix_is_refused_with_the_known_ones(tmp_path, name):
    for act in (lambda: save_run(build(), tmp_path / name), lambda: load_run(tmp_path / name)):
        with pytest.raises(ResultFileError, match=r"\.npz or \.csv"):
            act()
    assert list(tmp_path.iterdir()) == []


def test_a_missing_file_and_a_folder_are_refused(tmp_path):
    (tmp_path / "folder.npz").mkdir()

    with pytest.raises(ResultFileError, match="No such file"):
        load_run(tmp_path / "none.npz")
    with pytest.raises(ResultFileError, match="cannot read"):
        load_run(tmp_path / "folder.npz")
