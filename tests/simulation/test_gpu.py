"""Many runs on a graphics processor: its text, run here by a stand-in, has the bits of lanes.

The stand-in compiles the same text as C++ and runs one robot after the other.  The last test runs
CUDA if there is a device.
"""

import ctypes as ct
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from tests.simulation.campaign.studies import REAL
from tests.simulation.graphics import COMPILER, Stand
from tests.simulation.test_coupled import columns_of
from tests.tables import changes
from wmr_ctrl import simulate_many, simulate_runs, study
from wmr_ctrl.cli.root import root
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.core.errors import DeviceError, MissingExtraError
from wmr_ctrl.simulation import gpu
from wmr_ctrl.simulation.batch import run_tasks
from wmr_ctrl.simulation.campaign.plan import PlannedCase
from wmr_ctrl.simulation.campaign.study_chunks import StudyChunk, chunk_rows
from wmr_ctrl.simulation.campaign.study_run import _told
from wmr_ctrl.simulation.engines import check_device, runnable
from wmr_ctrl.simulation.memory import Task

SHORT = changes("clock.duration = 2.0; changes = [{t = 1.0, m = 3.3, I = 0.03, mu = 0.05}]")


@pytest.fixture
def stand(monkeypatch, request):
    if COMPILER is None:
        pytest.skip("NOT RUN: no C++ compiler is there")
    made = Stand(Path(request.config.cache.mkdir("gpu")), most=3)
    monkeypatch.setattr(gpu, "processor", lambda: made)
    monkeypatch.setattr("wmr_ctrl.simulation.engines.processor", lambda: made)
    return made


def assert_same(some, others):
    assert list(some) == list(others)
    for name, values in some.items():
        np.testing.assert_array_equal(others[name], values, err_msg=name)


@pytest.mark.slow
def test_figures_and_columns_are_those_of_lanes(stand):
    """The runs have encoders, delay, disturbances, and a change of the robot."""
    asked = ("robot-10ms", "prox", range(5))
    cpu, there = (simulate_many(*asked, SHORT, device=name) for name in ("cpu", "gpu"))
    assert_same(cpu, there)
    assert sorted(stand.launches) == [2, 3]
    runs, others = (
        simulate_runs(*asked[:2], range(2), overrides=SHORT, device=name) for name in ("cpu", "gpu")
    )
    for run, other in zip(runs, others, strict=True):
        assert (run.monitor, run.outcome) == (other.monitor, other.outcome)
        assert (run.engine, other.engine) == ("lanes", "gpu")
        for name in run.columns:
            np.testing.assert_array_equal(other[name], run[name], err_msg=name)


def test_a_launch_includes_nothing_and_takes_no_more_than_the_memory_holds(stand):
    task = Task(runnable(scenario_of("safe-simulation"), "prox", device="gpu"), 0)
    text = Path(task.loop.compiled.library).read_text(encoding="utf-8")
    assert "#include" not in text
    assert text.count("wmr_runs") == 1
    stand.most = 10**6
    assert gpu.robots_of(task, 11, log=False) < 10**6
    logged = gpu.robots_of(task, 11, log=True)
    numbers = task.loop.scenario.clock.samples * columns_of(task.loop)
    assert 1 <= logged <= stand.memory // 4 // (8 * numbers)


def test_a_cancelled_launch_ends_and_leaves_nothing(stand, monkeypatch):
    loop = runnable(scenario_of("safe-simulation"), "prox", device="gpu")
    run = Stand.run

    def interrupted(self, path, defines, batch, arrays, cancelled):
        cancelled.value = 1
        run(self, path, defines, batch, arrays, cancelled)
        assert not arrays["findings"][loop.compiled.layout.findings.index("samples")].any()
        raise KeyboardInterrupt

    monkeypatch.setattr(Stand, "run", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run_tasks([Task(loop, seed) for seed in range(3)])
    cancelled = ct.c_int32(1)
    monkeypatch.setattr(Stand, "run", run)
    assert gpu.launched([Task(loop, 0)], [], False, cancelled) is None


def test_a_study_has_the_same_table(stand, tmp_path, monkeypatch):
    monkeypatch.setattr("wmr_ctrl.simulation.campaign.study_run.GPU_CHUNK", 3)
    figures = ["violated", "position_rms"]
    plan = {**REAL, "guard": [False], "seeds": 4, "figures": figures, "chunk": 2}
    expected, found = (study(plan, tmp_path / name, device=name) for name in ("cpu", "gpu"))

    assert found.table.read_bytes() == expected.table.read_bytes()
    assert len(stand.launches) == 3


def test_without_cupy_or_a_device_there_is_a_sentence(tmp_path, monkeypatch):
    """A cluster's client needs no device, and a worker without one reports the lack."""
    gpu.processor.cache_clear()
    monkeypatch.setitem(sys.modules, "cupy", None)
    with pytest.raises(MissingExtraError, match=r"wmr_ctrl\[gpu\]"):
        simulate_many("far-start", "mb", [0], device="gpu")

    def fail(*_):
        raise RuntimeError("no driver")

    runtime = SimpleNamespace(CUDARuntimeError=RuntimeError, getDeviceProperties=fail)
    driverless = SimpleNamespace(runtime=runtime, Device=lambda: SimpleNamespace(id=0))
    monkeypatch.setitem(sys.modules, "cupy", SimpleNamespace(cuda=driverless))
    with pytest.raises(DeviceError, match="no CUDA device answers"):
        simulate_many("far-start", "mb", [0], device="gpu")
    plan = tmp_path / "plan.toml"
    plan.write_text('scenario = "far-start"\nlaws = ["mb"]\nseeds = 1\n', encoding="utf-8")
    words = ["study", str(plan), "--out", str(tmp_path / "out"), "--device", "gpu"]
    result = CliRunner().invoke(root, words)
    assert result.exit_code == 2
    assert "no CUDA device answers" in result.stderr
    assert not (tmp_path / "out").exists()
    check_device("gpu", here=False)
    case = PlannedCase(scenario_of("far-start"), "mb", False)
    answer = _told(chunk_rows, StudyChunk(((case, 0),), ("violated",), device="gpu"), 1)
    assert isinstance(answer, DeviceError)


def test_cuda_has_the_same_bits():
    gpu.processor.cache_clear()
    try:
        gpu.processor()
    except (MissingExtraError, DeviceError) as error:
        pytest.skip(f"NOT RUN: {error}")
    asked = ("robot-10ms", "prox", range(100), SHORT)
    assert_same(*(simulate_many(*asked, device=name) for name in ("cpu", "gpu")))
