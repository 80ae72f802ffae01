"""Who makes a study's chunks: threads, processes, clusters of Dask; the table is the same."""

import os
import pickle
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import pytest

import wmr_ctrl
from tests.simulation.campaign.studies import FACTS, PLAN, REAL, figures, refuse_after, table_of
from wmr_ctrl.core.errors import ScenarioError, UnknownNameError
from wmr_ctrl.simulation.campaign.engine import PlannedCase
from wmr_ctrl.simulation.campaign.study_chunks import StudyChunk
from wmr_ctrl.simulation.campaign.study_plan import plan_of
from wmr_ctrl.simulation.campaign.study_run import _told, run_study


@pytest.mark.parametrize("kind", [ThreadPoolExecutor, ProcessPoolExecutor])
def test_the_table_does_not_depend_on_the_executor(tmp_path, kind):
    with kind(2) as executor:
        run_study(plan_of(PLAN), tmp_path / "a", figures, FACTS, executor, 2)

    assert (tmp_path / "a" / "table.csv").read_bytes() == table_of(tmp_path / "b")


def test_a_worker_s_error_comes_back_as_it_is(tmp_path):
    """Dask prints what is raised in a worker: the error is sent back in place of rows."""
    with ThreadPoolExecutor(1) as pool, pytest.raises(ScenarioError, match=r"clock\.plant"):
        wmr_ctrl.study({**REAL, "grid": {"clock.control": [0.0105]}}, tmp_path, executor=pool)
    chunk = StudyChunk(((PlannedCase("far-start", "mb"), 0),), ("violated",))
    error = ScenarioError("no such robot")

    assert _told(refuse_after(0, error), chunk, None) is error
    unknown = UnknownNameError("law", "x", ("a", "b"))
    assert str(pickle.loads(pickle.dumps(unknown))) == str(unknown)


@pytest.mark.slow
def test_processes_of_a_local_cluster_give_the_same_bytes(tmp_path):
    """And so does a scheduler that is named, here with a worker in this process."""
    distributed = pytest.importorskip("distributed")
    here = wmr_ctrl.study(REAL, tmp_path / "a").table.read_bytes()
    there = wmr_ctrl.study({**REAL, "chunk": 2}, tmp_path / "b", executor="dask", jobs=2)
    one = {"n_workers": 1, "processes": False, "protocol": "tcp", "dashboard_address": None}
    with distributed.LocalCluster(**one) as cluster:
        address = cluster.scheduler_address.replace("tcp", "dask")
        named = wmr_ctrl.study(REAL, tmp_path / "c", executor=address)

    assert there.table.read_bytes() == named.table.read_bytes() == here


def heeding_interrupts():
    """Tests that run in a shell's background ignore Ctrl-C, and so would what they start."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="no signal to a whole group on Windows")
def test_who_interrupts_a_local_cluster_sees_no_traceback(tmp_path):
    """A terminal's Ctrl-C goes to the workers too."""
    pytest.importorskip("distributed")
    (tmp_path / "plan.toml").write_text('laws = ["mb"]\nseeds = 100000\nchunk = 20\n')
    command = [sys.executable, "-m", "wmr_ctrl", "study", "plan.toml", "--out", "s"]
    process = subprocess.Popen(
        [*command, "--executor", "dask", "--jobs", "2"], cwd=tmp_path, start_new_session=True,
        preexec_fn=heeding_interrupts,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    while process.poll() is None and not list((tmp_path / "s").glob("chunks/0*.npz")):
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGINT)
    told, _ = process.communicate(timeout=100)

    assert process.returncode == 130, told
    assert "the same command goes on from there" in told
    assert "Traceback" not in told
