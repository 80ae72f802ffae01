"""Every writer refuses an impossible folder in a sentence, and leaves nothing behind."""

import pytest

import wmr_ctrl
from tests.codegen.packages import write_package
from wmr_ctrl.core.errors import ResultFileError
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.runner import run_export

SCENARIO = load_scenario("paper-simulation-nominal")
WRITERS = {
    "codegen": lambda out: write_package("pid", out, SCENARIO),
    "modelica": lambda out: wmr_ctrl.export_fmu("modelica", scenario=SCENARIO, out=out),
    "simulink": lambda out: wmr_ctrl.export_fmu("simulink", law="pid", scenario=SCENARIO, out=out),
    "proofs": lambda out: run_export(out, ["guard.inside"]),
    "page": lambda out: wmr_ctrl.write_page(out / "page.html"),
}


@pytest.mark.parametrize("what", WRITERS)
@pytest.mark.slow_but("codegen", "simulink", "proofs", "page")
def test_a_folder_that_cannot_be(tmp_path, what):
    (tmp_path / "file").write_text("in place of a folder")

    with pytest.raises(ResultFileError, match=r"^cannot write .*\.$"):
        WRITERS[what](tmp_path / "file" / "below")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
