"""A user's laws, from a file with LAW or as a Law; each error is explained in a sentence."""

import numpy as np
import pytest

import wmr_ctrl
from tests.cli.conftest import SHORT
from tests.commands import flat
from tests.control.laws.toys import PLAIN, forget
from tests.docs.test_extending import FILES
from tests.tables import cases
from wmr_ctrl.core.errors import ArgumentError

LAW = FILES["my_law"]
BRIEF = {"clock.duration": 1.0, "changes": []}


@pytest.fixture(autouse=True)
def forgotten(monkeypatch, tmp_path):
    """Forget laws that a test hands over; give each test an empty folder."""
    forget(monkeypatch)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_law.py").write_text(LAW)


def line_of(text, part):
    return next(k for k, line in enumerate(text.splitlines(), start=1) if part in line)


@pytest.mark.parametrize(
    "old, new, said, line",
    cases("""
    force = | force = ( | never closed | force =
    context.friction | frction | 'frction' is not defined | force =
    law", force) | law", context.pose) | force has 3 elements | return
    force = | assert context.v[0] > 0;    force = | truth value | assert
    gain("K") | gain("Q") | known: K | force =
    return context.system | context.system | returns None | def build
    LAW = Law( | LAW = dict(name= | must be a Law | LAW =
    LAW = | import nowhere;LAW = | No module named 'nowhere' | nowhere
    unit=" | unt=" | unexpected keyword | K: tuple
    LAW = | exit();LAW = | ends the program | mine.py
    LAW = | law = | is called law: name it LAW | mine.py
    Law("my_law" | Law("pid" | a law of wmr_ctrl | LAW =
    Law("my_law" | Law("guard" | cannot be called 'guard' | LAW =
    doc=__doc__ | tuned=("Z",), doc=__doc__ | tuned names 'Z' | LAW =
    """),
)
def test_a_fault_names_file_and_line(old, new, said, line, wmr, tmp_path):
    text = LAW.replace(old, new.replace(";", "\n"), 1)
    assert text != LAW
    (tmp_path / "mine.py").write_text(text)

    result = wmr("run", "paper-simulation-nominal", "--law", "mine.py", *SHORT)

    told = flat(result.stderr)
    place = line if line == "mine.py" else f"mine.py, line {line_of(text, line)}"
    assert result.exit_code == 2
    assert said in told
    assert place in told
    assert "This should not happen" not in told


def test_laws_of_one_name_are_not_confused(tmp_path):
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "my_law.py").write_text(LAW.replace("context.friction", "0"))

    def speed(law):
        return wmr_ctrl.simulate("paper-simulation-nominal", law, overrides=BRIEF)["v1"]

    first, second, again = map(speed, ("./my_law.py", tmp_path / "b" / "my_law.py", "my_law.py"))

    assert np.array_equal(first, again)
    assert not np.allclose(first, second)
    plan = {"laws": ["my_law.py", "b/my_law.py"], "seeds": 1, "set": BRIEF}
    with pytest.raises(ArgumentError, match="two different laws are called 'my_law'"):
        wmr_ctrl.study(plan, tmp_path / "out")


def test_commands_take_files_among_names(wmr, tmp_path):
    short = "--set clock.duration=1 --set gains.my_law.K=300,30"
    compared = wmr(f"compare paper-simulation-nominal --law kanayama,my_law.py {short}")
    written = wmr("codegen my_law.py --out c")
    plan = tmp_path / "plans"
    plan.mkdir()
    (plan / "mine.py").write_text(LAW)
    (plan / "p.toml").write_text('laws = ["mine.py"]\nseeds = 1\n[set]\n"clock.duration" = 1.0\n')
    studied = wmr("study plans/p.toml --out st")

    assert (compared.exit_code, written.exit_code, studied.exit_code) == (0, 0, 0)
    assert "my_law" in compared.stdout
    assert (tmp_path / "c" / "wmr_my_law.c").exists()
    assert "0,my_law," in (tmp_path / "st" / "table.csv").read_text()
    assert sorted(path.name for path in tmp_path.rglob("*.pyc")) == []


def test_python_functions_take_laws():
    run = wmr_ctrl.simulate("paper-simulation-nominal", PLAIN, overrides=BRIEF)

    assert run.law == "plain"
    assert wmr_ctrl.linearize("paper-simulation-nominal", PLAIN).law == "plain"
    assert wmr_ctrl.compile_law(PLAIN, "paper-simulation-nominal").step().shape == (2,)
    with pytest.raises(ArgumentError, match="law = 3 must be str"):
        wmr_ctrl.simulate("paper-simulation-nominal", 3)


def test_a_scenario_names_a_file_beside_it(wmr, tmp_path):
    place = tmp_path / "robots"
    place.mkdir()
    (place / "mine.py").write_text(LAW)
    weak = "[gains.my_law]\nK = [300, 30]\n[actuator]\ntau_max = 1.0\n"
    text = f'extends = "paper-simulation-nominal"\nlaw = "mine.py"\n{weak}'
    (place / "mine.toml").write_text(text)

    result = wmr("run", "robots/mine.toml", *SHORT)

    assert result.exit_code == 0, result.stderr
    assert "my_law on mine" in result.stdout
    assert "--law robots/mine.py" in flat(result.stderr)
