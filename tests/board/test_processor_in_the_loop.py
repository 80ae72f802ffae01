"""The packages on emulated Cortex-M boards: controller there, plant here, in lockstep."""

from dataclasses import asdict

import pytest

from tests.board.emulated import missing
from tests.board.lockstep import lockstep
from tests.codegen.measured import BOARD, loop_scenario
from wmr_ctrl.codegen.package import known_footprint, packaged, step_kernel
from wmr_ctrl.control.setup import settle

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing())

TOLERANCE = {False: 0.0, True: 5e-5}
"""Largest torque difference from the host's build of the same precision, relative to 1 N m + the
torque, memories carried on for 10 s: none in double precision, whose mathematics is our own; in
single precision there are two mathematics libraries."""


@pytest.mark.parametrize("law, float32, guarded", [("nn", True, False), ("nn", False, True)])
@pytest.mark.slow
def test_ten_seconds_in_lockstep(law, float32, guarded, tmp_path, record_property):
    scenario = loop_scenario(guarded)
    found = lockstep(law, scenario, BOARD, tmp_path, float32=float32)
    for name, value in asdict(found).items():
        record_property(name, value)

    assert found.worst <= TOLERANCE[float32]
    assert found.distance < 0.2
    operations = step_kernel(packaged(settle(scenario, law))).operations
    told = known_footprint(law, float32, guarded, operations)
    assert found.most_instructions <= 1.1 * told.most_instructions + 80
    assert found.stack <= 1.1 * told.deepest
