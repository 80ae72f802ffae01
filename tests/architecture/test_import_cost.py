"""Importing the package, and asking for help, loads none of the heavy dependencies."""

import subprocess
import sys

import pytest

import wmr_ctrl

HEAVY = {"casadi", "control", "fmpy", "matplotlib", "scipy.optimize"}


def loaded_after(statements):
    """Heavy modules that a fresh interpreter has loaded after some statements."""
    script = f"import sys\n{statements}\nprint('LOADED', *sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    return HEAVY & set(done.stdout.rpartition("LOADED")[2].split())


def test_import_of_the_package_is_light():
    assert loaded_after("import wmr_ctrl; wmr_ctrl.__version__; dir(wmr_ctrl)") == set()


@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["run", "--help"]])
def test_help_of_the_command_line_is_light(arguments):
    statements = (
        f"sys.argv = ['wmr-ctrl', *{arguments!r}]\n"
        "from wmr_ctrl.__main__ import main\n"
        "try: main()\n"
        "except SystemExit as end: assert not end.code, end.code"
    )

    assert loaded_after(statements) == set()


@pytest.mark.parametrize("module", [
    "results", "simulation.interpreted", "simulation.campaign.study_run", "world.scenario",
])  # fmt: skip
@pytest.mark.slow_but("simulation.campaign.study_run")
def test_workers_start_without_casadi_and_plots(module):
    assert loaded_after(f"import wmr_ctrl.{module}") <= {"scipy.optimize"}


def test_public_names_are_there_and_load_on_first_use():
    assert [name for name in wmr_ctrl.__all__ if getattr(wmr_ctrl, name, None) is None] == []
    assert set(wmr_ctrl.__all__) <= set(dir(wmr_ctrl))


def test_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no_such_name"):
        wmr_ctrl.no_such_name  # noqa: B018  # the access is the test
