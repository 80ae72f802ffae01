"""A robot's own bag in show, compare, pictures and films: its data, and the names of the rest."""

import json
import math

import numpy as np
import pytest
from click.testing import CliRunner

from tests.commands import flat
from tests.results.test_bag_topics import EPOCH, ODOMETRY, TWIST, bag, joints_at, odometry, twist
from tests.tables import cases
from wmr_ctrl import load_drive, load_run
from wmr_ctrl.cli import root
from wmr_ctrl.core.errors import ResultFileError, UnknownNameError
from wmr_ctrl.identification.logs.log import log_of
from wmr_ctrl.results.drive import UNITS

T = np.arange(0, 6, 0.1)


def circle(t):
    """Pose (x, y, yaw) of a base that drives 0.4 m/s and turns 0.5 rad/s."""
    return 0.8 * math.sin(0.5 * t), 0.8 * (1 - math.cos(0.5 * t)), 0.5 * t


def messages(late=0.003):
    """Messages of a base: odometry, commands at half its rate, wheels without efforts."""
    odom = [
        ("/base/odom", ODOMETRY, EPOCH + t + late, odometry(EPOCH + t, 0.4, 0.5, circle(t)))
        for t in T
    ]
    sent = [("/cmd_vel", TWIST, EPOCH + t, twist(0.4, 0.5)) for t in T[::2]]
    return odom + sent + joints_at(EPOCH + T, lambda t: (4.5 * t, 3.5 * t), lambda t: (4.5, 3.5))


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    return bag(tmp_path_factory.mktemp("recorded"), messages())


@pytest.fixture(scope="module")
def commands_alone(tmp_path_factory):
    listed = [row for row in messages() if row[0] == "/cmd_vel"]
    return bag(tmp_path_factory.mktemp("commands"), listed)


def invoke(*words):
    return CliRunner().invoke(root, [str(word) for word in words])


def test_show_lists_what_a_base_recorded_and_names_what_it_did_not(recorded):
    done = invoke("show", recorded, "--json")
    told = json.loads(done.stdout)

    assert done.exit_code == 0, done.stderr
    assert set(told["columns"]) | set(told["missing"]) == set(UNITS)
    assert told["missing"] == ["tau_right", "tau_left"]
    assert told["columns"]["v_command"]["samples"] == len(T[::2])
    assert told["columns"]["v1_measured"]["longest_gap"] == pytest.approx(0.1)
    assert told["way"] == pytest.approx(0.4 * T[-1], rel=1e-3)
    assert (told["max_abs_v1"], told["max_abs_v2"]) == (0.4, 0.5)
    assert told["tau_peak"] is None
    text = flat(invoke("show", recorded).stdout)
    for sentence in ("not there: tau_right, tau_left", "nothing is judged", "the longest gap is",
                     "recorded 3 ms after its stamps"):  # fmt: skip
        assert sentence in text


def test_show_draws_and_saves_it(recorded, tmp_path):
    files = [tmp_path / name for name in ("drive.png", "drive.csv")]
    done = invoke("show", recorded, "--plot", files[0], "--out", files[1])

    assert done.exit_code == 0, done.stderr
    assert files[0].read_bytes().startswith(b"\x89PNG")
    assert files[1].is_file()


def test_a_saved_drive_is_the_log_that_identify_reads(recorded, tmp_path):
    """Columns of several rates, with empty cells: the bits of the bag."""
    load_drive(recorded).save(tmp_path / "log.csv")
    log, drive = log_of(tmp_path / "log.csv"), log_of(recorded)

    assert set(log.columns) == set(drive.columns)
    for name, values in drive.columns.items():
        assert log.columns[name].tobytes() == values.tobytes()
        assert log.times[name].tobytes() == drive.times[name].tobytes()


@pytest.mark.parametrize(
    "words, said",
    cases("""
    --animate OUT.gif | --animate are of a run
    --report OUT.html | Use --plot
    --out OUT.npz | must end in .csv
    --topics odom=/nowhere | no topic /nowhere
    --topics odom | must be ROLE=NAME
    """),
)
def test_an_impossible_request_writes_no_file(commands_alone, tmp_path, words, said):
    given = words.replace("OUT", str(tmp_path / "out")).split()
    done = invoke("show", commands_alone, "--plot", tmp_path / "plot.png", *given)

    assert done.exit_code == 2
    assert said in flat(done.stderr)
    assert list(tmp_path.iterdir()) == []


def test_a_column_by_its_name_and_one_that_is_not_there(recorded):
    drive = load_drive(recorded)

    assert "v1_measured" in drive
    assert set(drive["v1_measured"]) == {0.4}
    assert len(drive["v_command"]) == len(drive.times["v_command"]) == len(T[::2])
    assert repr(drive) == f"<RecordedDrive {recorded.name}, 5.9 s: {', '.join(drive.columns)}>"
    for name in ("tau_right", "x_d"):
        assert name not in drive
        with pytest.raises(UnknownNameError, match="v1_measured"):
            drive[name]


def test_a_bag_is_refused_as_a_run_with_the_remedy(recorded, commands_alone, tmp_path):
    for place in (recorded, next(commands_alone.glob("*.mcap"))):
        with pytest.raises(ResultFileError, match=r"no desired motion.*wmr_ctrl\.load_drive"):
            load_run(place)
