"""No command replaces a file that it reads, whatever name the path has."""

import os
import shutil
from contextlib import suppress
from pathlib import Path

import click
import pytest

from tests.commands import flat
from tests.papers_robot import HEAD
from tests.tables import cases
from wmr_ctrl.cli import root
from wmr_ctrl.core.errors import ResultFileError, WmrError
from wmr_ctrl.core.fields.files import note_input, one_command, read_text
from wmr_ctrl.export.cosim.mapping import load_map
from wmr_ctrl.export.cosim.slave import FmuFile
from wmr_ctrl.identification.logs.log import log_of
from wmr_ctrl.results import atomic_text, check_writable, load_run, write_all
from wmr_ctrl.results.bag_topics import load_drive
from wmr_ctrl.simulation.campaign.study_plan import load_plan
from wmr_ctrl.simulation.tuning import tune
from wmr_ctrl.world.scenario import load_scenario

COMMANDS = """
check mine.toml
run mine.toml
cosim mine.toml
compare mine.toml --law pid
show saved.csv
tune mine.toml --law pid
identify log.csv --robot mine.toml
page --scenario mine.toml
study plan.toml --out s
dossier mine.toml
"""
"""Calls of each command that writes named files, with a file that it reads as the output."""
FOLDERS = """
study plan.toml --out | table.csv
codegen pid --scenario mine.toml --out | README.md
export modelica --scenario mine.toml --out | WheeledRobot.mo
linearize circle.toml --law pid --plot | circle-pid-bode.png
"""
"""Calls of commands that write a folder, with a file that they read in it."""
READS_NOTHING = ("prove", "bench", "reproduce")
SUFFIXES = (".csv", ".npz", ".svg", ".png", ".html", ".toml", ".gif", ".yaml")


def outputs(metavar):
    """Every command's options for a file or folder to write."""
    for name, command in root.commands.items():
        for option in command.params:
            writes = isinstance(option, click.Option) and option.metavar == metavar
            if writes and name not in READS_NOTHING:
                slow = [pytest.mark.slow] if name == "linearize" else []
                yield pytest.param(name, option.opts[0], marks=slow)


@pytest.fixture
def place(tmp_path, monkeypatch, short_run):
    """The working folder, with a scenario that reads a path, a plan and a log."""
    monkeypatch.chdir(tmp_path)
    Path("path.csv").write_text("x,y\n0,0\n1,0\n2,1\n")
    Path("robot.toml").write_text(HEAD + '[reference]\nkind = "waypoints"\nfile = "path.csv"\n')
    Path("mine.toml").write_text('extends = "robot.toml"\nclock.duration = 0.2\n')
    Path("circle.toml").write_text(HEAD + "clock.duration = 0.2\n")
    Path("plan.toml").write_text('scenario = "mine.toml"\nlaws = ["pid"]\nseeds = 1\n')
    assert short_run("--out saved.csv").exit_code == 0
    shutil.copy("saved.csv", "log.csv")
    return tmp_path


def refused(result):
    return result.exit_code == 2 and "the same command reads this file" in flat(result.stderr)


def test_every_output_says_that_it_is_one():
    """Options of outputs have one of two placeholders, by which the tests below find them."""
    for command in root.commands.values():
        for option in command.params:
            if isinstance(option, click.Option) and "--out" in option.opts:
                assert option.metavar in ("FILE", "DIR"), command.name


@pytest.mark.parametrize("name, option", [*outputs("FILE")])
def test_no_file_that_is_read_is_replaced(wmr, place, name, option):
    (line,) = (line for line in COMMANDS.splitlines() if line.startswith(name))
    source = next(Path(word) for word in line.split() if Path(word).suffix in (".toml", ".csv"))
    before = source.read_bytes()
    found = []
    for suffix in SUFFIXES:
        link = Path(f"link{suffix}")
        link.symlink_to(source)
        found.append(wmr(f"{line} {option} {link}"))
        link.unlink()

    assert any(map(refused, found)), [result.stderr for result in found]
    assert all(result.exit_code == 2 for result in found)
    assert source.read_bytes() == before


@pytest.mark.parametrize("name, option", [*outputs("DIR")])
def test_no_file_that_is_read_is_replaced_in_a_folder(wmr, place, name, option):
    (row,) = (row for row in FOLDERS.splitlines() if row.startswith(name))
    command, file = row.split(f"{option} | ")
    (source,) = (word for word in command.split() if word.endswith(".toml"))
    Path("there").mkdir()
    os.link(source, Path("there", file))

    assert refused(wmr(f"{command} {option} there"))
    assert Path("there", file).samefile(source)


@pytest.mark.parametrize(
    "path",
    cases("""
    path.csv
    ./path.csv
    folder/../path.csv
    nowhere/../path.csv
    PLACE/path.csv
    hard.csv
    symbolic.csv
    """),
)
def test_any_spelling_is_seen(wmr, place, path):
    Path("folder").mkdir()
    os.link("path.csv", "hard.csv")
    Path("symbolic.csv").symlink_to("path.csv")
    result = wmr("run", "mine.toml", "--out", path.replace("PLACE", str(place)))

    assert refused(result)
    assert "reference.file: path.csv" in flat(result.stderr)
    assert Path("path.csv").read_text().startswith("x,y")


def test_function_that_reads_and_writes_is_a_command(place):
    with pytest.raises(ResultFileError, match="the same command reads this file"):
        tune("mine.toml", "pid", "mine.toml")


READERS = {
    "mine.toml": load_scenario,
    "plan.toml": load_plan,
    "map.toml": load_map,
    "saved.csv": load_run,
    "log.csv": log_of,
    "bag.db3": load_drive,
    "plant.fmu": lambda path: FmuFile(path, "plant"),
}


@pytest.mark.parametrize("file", READERS)
def test_each_kind_of_file_is_noted_when_it_is_read(place, file):
    Path(file).touch()
    with one_command():
        with suppress(WmrError):  # some of them are empty
            READERS[file](file)
        with pytest.raises(ResultFileError, match="the same command reads this file"):
            check_writable(file)


def test_files_of_a_bag_are_noted(place):
    Path("drive").mkdir()
    for name in ("metadata.yaml", "drive_0.mcap"):
        Path("drive", name).touch()
    with one_command():
        with suppress(WmrError):
            load_drive("drive")
        with pytest.raises(ResultFileError, match=r"bag: .*drive_0\.mcap"):
            check_writable("drive/drive_0.mcap")


def test_file_is_free_again_after_the_command(place):
    with one_command():
        with one_command():
            read_text(Path("mine.toml"), "scenario")
        with pytest.raises(ResultFileError, match=r"scenario: mine\.toml"):
            write_all({"mine.toml": ""}, place)
    with atomic_text("mine.toml") as file:
        file.write("")


def test_file_to_be_written_is_not_read_any_more(place):
    with one_command(), atomic_text("mine.toml"), pytest.raises(ResultFileError, match="plan"):
        note_input("mine.toml", "plan")
