"""The comparison for other tools' results, and the workflows that call it."""

import re
import shlex
from pathlib import Path

import pytest

from tests.importers.match import main
from wmr_ctrl.api import export_fmu
from wmr_ctrl.cli.root import root

ROOT = Path(__file__).resolve().parents[2]
WORKFLOW = ROOT / ".github/workflows/importers.yml"


@pytest.fixture(scope="module")
def plant(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fmus")
    return export_fmu("plant", scenario="paper-simulation-nominal", fmi="2", out=folder)[0]


@pytest.mark.parametrize("torque, said", [(5.0, "AGREES to 1e-09"), (5.001, "DIFFERS")])
def test_the_same_result_agrees_and_another_input_is_seen(plant, tmp_path, capsys, torque, said):
    """The result is in the form that FMPy's own command writes."""
    result = pytest.importorskip("fmpy").simulate_fmu(
        str(plant), stop_time=2.0, step_size=0.01, output_interval=0.01,
        start_values={"tau_right": torque, "tau_left": 4.5},
    )  # fmt: skip
    rows = [map(repr, result.dtype.names), *(map(repr, map(float, row)) for row in result)]
    path = tmp_path / "result.csv"
    path.write_text("\n".join(map(",".join, rows)).replace("'", '"'), encoding="utf-8")

    assert main([str(path), str(plant)]) == (torque != 5.0)
    assert said in capsys.readouterr().out


@pytest.mark.parametrize("text", ["", "time,x\n0,1\n", "time,a\n0,b\n", "time,other\n0,0\n" * 2])
def test_what_cannot_be_compared_never_agrees(plant, tmp_path, text):
    path = tmp_path / "result.csv"
    path.write_text(text, encoding="utf-8")

    assert main([str(path), str(plant)]) == 2


def test_the_later_row_of_an_instant_counts(tmp_path):
    """A Modelica tool writes the values before and after a sample."""
    wanted = "time,u\n" + "".join(f"{k / 100},{k}\n" for k in range(20))
    found = "time,u\n" + "".join(f"{k / 100},{k - 1}\n{k / 100},{k}\n" for k in range(20))
    for name, text in (("wanted.csv", wanted), ("found.csv", found)):
        (tmp_path / name).write_text(text, encoding="utf-8")

    assert main([str(tmp_path / "found.csv"), str(tmp_path / "wanted.csv")]) == 0


def test_commands_of_the_workflow_exist():
    text = re.sub(r"\$\{\{.*?\}\}", "", WORKFLOW.read_text(encoding="utf-8"))
    calls = [shlex.split(line) for line in re.findall(r"wmr-ctrl (.+)$", text, flags=re.M)]

    assert len(calls) >= 3
    for name, *words in calls:
        known = {option for item in root.commands[name].params for option in item.opts}
        assert {word for word in words if word.startswith("--")} <= known
    for script in re.findall(r"tests/importers/\w+\.\w+", text):
        assert (ROOT / script).is_file()
