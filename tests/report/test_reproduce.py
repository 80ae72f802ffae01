"""The main job from end to end: refusals before anything runs, and its result."""

import pytest
from click.testing import CliRunner

from tests.simulation.campaign.synthetic import made_up as made_up_runs
from wmr_ctrl import api
from wmr_ctrl.cli import root
from wmr_ctrl.core.errors import ArgumentError, MissingExtraError, ResultFileError
from wmr_ctrl.report.report_page import Facts


def never(*_args):
    raise AssertionError("nothing must run")


@pytest.fixture
def idle(monkeypatch):
    """Fail if anything is compiled or run."""
    monkeypatch.setattr(api, "compile_law", never)
    monkeypatch.setattr("wmr_ctrl.simulation.campaign.engine.build_loop", never)


@pytest.fixture
def made_up(monkeypatch):
    """Made-up runs in place of the engine."""
    monkeypatch.setattr(api, "_facts", lambda laws, quick: Facts())
    with made_up_runs():
        yield


@pytest.mark.usefixtures("idle")
@pytest.mark.parametrize("wrong", [{"seeds": 0}, {"jobs": 0}, {"quick": True, "jobs": -1}])
def test_impossible_orders_are_refused_before_anything_runs(tmp_path, wrong):
    with pytest.raises(ArgumentError):
        api.reproduce(tmp_path / "new", **wrong)
    assert not (tmp_path / "new").exists()


@pytest.mark.usefixtures("idle")
@pytest.mark.parametrize("place", ["file", "file/below", "folder"])
def test_places_that_cannot_be_written_are_refused_before_anything_runs(tmp_path, place):
    (tmp_path / "file").write_text("mine")
    (tmp_path / "folder" / "report.html").mkdir(parents=True)

    with pytest.raises(ResultFileError):
        api.reproduce(tmp_path / place)
    assert (tmp_path / "file").read_text() == "mine"
    (tmp_path / "ours.csv").mkdir()
    with pytest.raises(ResultFileError, match="ours"):
        api.reproduce(tmp_path, with_ours=True)


@pytest.mark.usefixtures("idle")
def test_without_the_extra_the_rigid_body_is_refused_before_anything_runs(tmp_path, monkeypatch):
    def absent(name):
        raise ImportError(name)

    monkeypatch.setattr("wmr_ctrl.simulation.physics.rigid.import_module", absent)
    with pytest.raises(MissingExtraError, match=r"wmr_ctrl\[physics\]"):
        api.reproduce(tmp_path / "new", with_physics=True)
    line = ("reproduce", "--quick", "--with-physics", "--out", str(tmp_path / "new"))
    done = CliRunner().invoke(root, line)
    assert done.exit_code == 2
    assert "wmr_ctrl[physics]" in done.stderr
    assert not (tmp_path / "new").exists()


@pytest.mark.usefixtures("made_up")
def test_a_campaign_that_fails_leaves_nothing(tmp_path):
    def fail(scenario, law, seed):
        raise RuntimeError("no")

    with made_up_runs(fail), pytest.raises(RuntimeError):
        api.reproduce(tmp_path / "new", seeds=1)
    assert not (tmp_path / "new").exists()


def test_quick_does_not_compare_the_graphs_with_the_ledger(monkeypatch):
    monkeypatch.setattr("wmr_proofs.runner.stale_entries", lambda: ("an.entry",))

    assert api._facts((), quick=True).stale is None
    assert api._facts((), quick=False).stale == ("an.entry",)


@pytest.mark.slow
@pytest.mark.usefixtures("few_pictures")
def test_the_verdicts_are_the_committed_ones_with_one_seed_too(tmp_path, monkeypatch):
    """One seed gives the committed verdicts.

    The test in tests/packaging/test_wheel.py takes three seeds and every picture, and reads the
    exit code; tests/proofs compares the graphs with the ledger.
    """
    monkeypatch.setattr("wmr_proofs.runner.stale_entries", list)
    verdicts = api.reproduce(tmp_path / "out", seeds=1)

    assert verdicts.changed == ()
    assert verdicts.ok
