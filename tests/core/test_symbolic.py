"""CasADi is loaded when it is first used."""

import subprocess
import sys

import casadi
import pytest

from wmr_ctrl.core.symbolic import ca


def test_it_is_casadi_and_keeps_what_was_asked_for():
    assert ca.SX is casadi.SX
    assert vars(ca)["SX"] is casadi.SX
    with pytest.raises(AttributeError, match="nothing"):
        _ = ca.nothing


def test_importing_it_loads_nothing():
    script = (
        "import sys; from wmr_ctrl.core.symbolic import ca; assert 'casadi' not in sys.modules; "
        "ca.SX; assert 'casadi' in sys.modules"
    )
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 0
