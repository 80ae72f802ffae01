"""The closed-loop FMU shows the bits of the native loop, over 80 s."""

import numpy as np
import pytest
from fmpy import simulate_fmu

from tests.bits.cases import SEED, case
from wmr_ctrl.api import export_fmu
from wmr_ctrl.core.signals import elements
from wmr_ctrl.simulation.memory import Task, laid_out

AFTER = {"x", "y", "theta", "v1", "omega", "psi"}
"""Columns that the log has before a sample, and an FMU after it."""


@pytest.mark.slow
@pytest.mark.parametrize("law, name", [("nn", "plain"), ("mb", "everything")])
def test_all_columns(law, name, tmp_path, monkeypatch):
    for variable in ("WMR_CTRL_OPTIMIZE", "WMR_CTRL_FMU_CC"):  # as FMUs are shipped
        monkeypatch.delenv(variable, raising=False)
    one = case(law, name)
    memory = laid_out([Task(one.loop, SEED)], [], log=True)
    memory.run()
    rows, names = memory.logged(0), elements(one.compiled.layout.columns)
    scenario = one.setup.scenario
    (path,) = export_fmu(
        "closed-loop", law=law, scenario=scenario, fmi=3, out=tmp_path, arrays=False
    )
    shown = simulate_fmu(
        str(path), stop_time=scenario.clock.duration, output_interval=scenario.clock.control,
        start_values={"seed": SEED}, output=names[1:],
    )  # fmt: skip

    assert len(shown) == len(rows) + 1
    for place, column in enumerate(names[1:], 1):
        wanted = rows[:, place]
        values = shown[column][:-1] if column in AFTER else shown[column][1:]
        assert np.array_equal(values.view("<u8"), wanted.copy().view("<u8")), column
