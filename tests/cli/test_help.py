"""Help texts: complete, narrow, quick."""

import re
import subprocess
import sys

import click
import pytest

from tests.commands import flat
from wmr_ctrl.cli import root
from wmr_ctrl.cli.evidence import QUICK, SEEDS
from wmr_ctrl.cli.exports import WITH_LAW
from wmr_ctrl.codegen.resources import LAYOUTS

COMMANDS = [*root.commands]


def test_commands_are_listed_in_the_order_in_which_one_meets_them(wmr):
    found = wmr("--help")

    assert found.exit_code == 0
    listed = re.findall(r"^  ([a-z]+) +[A-Z]", found.stdout.partition("Robot:")[2], re.M)
    assert listed == COMMANDS
    assert " ".join(listed) == (
        "new scenarios laws check run compare show study tune identify "
        "codegen export cosim page linearize reproduce prove dossier bench"
    )
    assert wmr().stdout == found.stdout


@pytest.mark.parametrize("name", COMMANDS)
def test_help_fits_eighty_columns_and_explains_every_option(wmr, name):
    whole, short, command = wmr(name, "--help"), wmr(name, "-h"), root.commands[name]

    assert (whole.exit_code, short.exit_code) == (0, 0), whole.stderr + short.stderr
    assert max(map(len, whole.stdout.splitlines())) <= 80
    assert short.stdout == whole.stdout
    assert command.short_help.endswith(".")
    assert len(command.short_help) < 66
    assert all(isinstance(item, click.Argument) or item.help for item in command.params)


def test_help_texts_name_what_the_code_has(wmr):
    (layout,) = (item for item in root.commands["codegen"].params if item.name == "layout")

    assert tuple(layout.type.choices) == LAYOUTS
    assert f"Law for {', '.join(WITH_LAW[:-1])} and {WITH_LAW[-1]}." in words(wmr("export -h"))
    assert f"[default: {SEEDS}, or {QUICK} with --quick]" in words(wmr("reproduce -h"))


def words(found):
    return flat(found.stdout)


def test_help_imports_nothing_heavy(environment):
    code = (
        "import sys\n"
        "from wmr_ctrl.cli import root\n"
        "try: root.main(['--help'])\n"
        "except SystemExit: pass\n"
        "heavy = {'casadi', 'control', 'matplotlib', 'numpy', 'scipy', 'rich'}\n"
        "sys.exit(', '.join(sorted(heavy & set(sys.modules))) or 0)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True)

    assert done.stderr.decode() == ""
    assert done.returncode == 0
