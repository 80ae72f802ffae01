"""Claims and the committed ledger belong together."""

from __future__ import annotations

import pytest

from wmr_ctrl.errors import UnknownNameError
from wmr_ctrl.proofs import check, command, prove
from wmr_ctrl.proofs.claims import all_claims
from wmr_ctrl.proofs.ledger import exit_code, load, stale
from wmr_ctrl.proofs.runner import hashes, selected

QUICK = [
    "eq03",
    "eq25",
    "eq25.printed",
    "eq79.printed",
    "eq86",
    "thm1.global",
    "authority.limit-reached",
    "lemma.log",
]


def test_ids_are_unique_and_those_of_the_committed_ledger() -> None:
    ids = [claim.id for claim in all_claims()]

    assert len(ids) == len(set(ids))
    assert ids == [entry.id for entry in load().entries]


def test_no_committed_verdict_is_about_another_graph() -> None:
    assert stale(hashes(), load()) == []


def test_committed_counterexamples_still_refute() -> None:
    committed = load().by_id()
    refuted = [claim for claim in all_claims() if committed[claim.id].verdict == "REFUTED"]

    assert len(refuted) >= 12
    assert [c.id for c in refuted if not check.recheck(c, committed[c.id])] == []


def test_a_selection_runs_and_agrees_with_the_committed_ledger() -> None:
    seen = []

    ledger = prove(QUICK, lambda done, total, entry: seen.append((done, total)), processes=1)

    assert exit_code(ledger, load(), complete=False) == 0
    assert seen[-1] == (len(ledger.entries), len(ledger.entries))


def test_a_beginning_selects_all_of_its_kind() -> None:
    assert set(selected(["authority"])) >= {"authority.shape", "authority.limit"}
    with pytest.raises(UnknownNameError, match="eq25"):
        selected(["eq2x"])


def test_missing_packages_are_said_and_never_proved(monkeypatch, capsys) -> None:
    monkeypatch.setattr(check, "missing", lambda method: ("z3",) if method else ())
    monkeypatch.setattr(command, "prove", lambda only, progress: prove(only, progress, processes=1))

    assert command.run_prove(["eq86", "eq03", "lemma.log"]) == 3
    assert "pip install" in capsys.readouterr().out


def test_json_file(tmp_path) -> None:
    assert command.run_prove(["eq25"], tmp_path / "out.json") == 0
    assert '"entries"' in (tmp_path / "out.json").read_text(encoding="utf-8")


@pytest.mark.slow
def test_everything_is_as_committed() -> None:
    assert exit_code(prove(), load()) == 0
