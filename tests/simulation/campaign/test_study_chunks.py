"""Executors of a study's chunks: threads, processes, clusters of Dask; the table is the same."""

import pickle
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
    """Dask would print an exception raised in a worker, so the error is returned in place of
    rows.
    """
    with ThreadPoolExecutor(1) as pool, pytest.raises(ScenarioError, match=r"clock\.plant"):
        wmr_ctrl.study({**REAL, "grid": {"clock.control": [0.0105]}}, tmp_path, executor=pool)
    chunk = StudyChunk(((PlannedCase("far-start", "mb"), 0),), ("violated",))
    error = ScenarioError("no such robot")

    assert _told(refuse_after(0, error), chunk, None) is error
    unknown = UnknownNameError("law", "x", ("a", "b"))
    assert str(pickle.loads(pickle.dumps(unknown))) == str(unknown)


@pytest.mark.slow
def test_processes_of_a_local_cluster_give_the_same_bytes(tmp_path):
    """So does a named scheduler, here with a worker in this process."""
    distributed = pytest.importorskip("distributed")
    here = wmr_ctrl.study(REAL, tmp_path / "a").table.read_bytes()
    there = wmr_ctrl.study({**REAL, "chunk": 2}, tmp_path / "b", executor="dask", jobs=2)
    one = {"n_workers": 1, "processes": False, "protocol": "tcp", "dashboard_address": None}
    with distributed.LocalCluster(**one) as cluster:
        address = cluster.scheduler_address.replace("tcp", "dask")
        named = wmr_ctrl.study(REAL, tmp_path / "c", executor=address)

    assert there.table.read_bytes() == named.table.read_bytes() == here
