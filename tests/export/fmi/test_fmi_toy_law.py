"""A law from another package becomes FMUs without a line in the exporter."""

from importlib.metadata import EntryPoint

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from wmr_ctrl.api import simulate
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.export.cosim import cosimulate
from wmr_ctrl.export.fmi.fmu_files import export_fmu
from wmr_ctrl.world.scenario import load_scenario, override


@pytest.fixture
def toy(monkeypatch):
    entry = EntryPoint("toy", "tests.export.fmi.toy_law:LAW", "wmr_ctrl.laws")
    monkeypatch.setitem(LAWS.plugins, "toy", entry)


@pytest.mark.usefixtures("toy")
@pytest.mark.slow
def test_a_law_of_another_package_is_exported_and_simulated(tmp_path):
    paths = [*export_fmu("toy", out=tmp_path), *export_fmu("closed-loop", law="toy", out=tmp_path)]
    names = {path.name for path in paths}
    assert names == {f"wmr_{w}.fmi{v}.fmu" for w in ("toy", "closed-loop") for v in (2, 3)}
    assert all(validate_fmu(str(path)) == [] for path in paths)
    short = override(load_scenario("paper-simulation"), {"clock.duration": 1.0, "changes": []})
    assert np.array_equal(cosimulate(short, "toy")["v1"], simulate(short, "toy")["v1"])
