"""Consistency of the claims and the committed ledger."""

import gc
import re
import subprocess
import sys
import time
from fractions import Fraction
from pathlib import Path

import pytest

from tests.proofs import second_solvers
from wmr_ctrl.core.errors import UnknownNameError
from wmr_ctrl.results.ledger import Ledger, load
from wmr_proofs import entry as entries
from wmr_proofs import prove, runner
from wmr_proofs.alterations import function_named
from wmr_proofs.claim import CLAIMED, MUTATED, Claims
from wmr_proofs.claims import all_claims
from wmr_proofs.comparison import differences, exit_code, stale
from wmr_proofs.methods.point import judge
from wmr_proofs.methods.spec import versions
from wmr_proofs.runner import hashes, selected

IDS = [claim.id for claim in all_claims()]
EACH = 24
"""Step through the entries by default; with ``slow`` all are tested."""


def test_ids_are_unique_and_those_of_the_committed_ledger():
    assert len(IDS) == len(set(IDS))
    assert [entry.id for entry in load().entries] == IDS


def test_docstring_has_words_meaning_and_hypotheses():
    claim = Claims(by="HAND", given="another default")

    @claim("of.{axis}", axis="v")
    def stated(_):
        """{axis} <= V.

        The {axis} axis is limited.

        Given: {axis} real; {INTERVALS}.
        """

    (found,) = claim.listed
    assert (found.id, found.claim, found.meaning) == ("of.v", "v <= V", "The v axis is limited.")
    assert found.hypotheses == "v real; 0 < K_min <= K <= K_max, |d| <= dbar < V"


def test_each_argument_by_hand_names_its_theorem_and_what_would_break_it():
    page = (Path(__file__).parents[2] / "docs" / "lemmas.md").read_text("utf-8")
    rows = re.findall(r"^\| ([^|]+) \| ([^|]+) \| ([^|]+) \|$", page, re.MULTILINE)[1:]
    named = [key for _, keys, _ in rows for key in keys.split(", ")]

    assert sorted(named) == sorted(claim.id for claim in all_claims() if claim.verdict == "HAND")
    assert {f"## {key}" for key in named} <= set(page.splitlines())


def test_no_entry_by_machine_speaks_of_all_time():
    forever = re.compile(r"for ever\b|at all times|at every instant from|ever again|all samples")
    others = (claim for claim in all_claims() if claim.verdict != "HAND")

    assert [c.id for c in others if forever.search(f"{c.claim} {c.meaning}")] == ["guard.late.tail"]


def test_no_committed_verdict_is_about_another_graph():
    assert stale(hashes(set(IDS[::EACH])), load()) == []


@pytest.mark.slow
def test_nor_is_that_of_any_other_entry():
    assert stale(hashes(set(IDS) - set(IDS[::EACH])), load()) == []


@pytest.mark.slow
def test_what_other_versions_decided_is_proved_again():
    """What these versions decided is proved again by the slow test below."""
    committed = load().by_id()
    others = [
        claim.id
        for claim in all_claims()
        if claim.method and differing(versions(claim.method), committed[claim.id].versions)
    ]

    ledger = prove(others) if others else Ledger(())
    assert [(d.id, d.now) for d in differences(ledger, load(), complete=False)] == []


def differing(now, then):
    return any(then.get(name) != version for name, version in now.items())


def refutes(claim, entry):
    """True if the entry's stored counterexample still refutes the claim on the graph."""
    assert claim.statement is not None
    texts = entry.counterexample.items()
    point = {name: value if value.endswith("pi") else Fraction(value) for name, value in texts}
    given, goal = judge(claim.statement(CLAIMED), point)
    return given and not goal


def test_committed_counterexamples_still_refute():
    committed = load().by_id()
    refuted = [claim for claim in all_claims() if committed[claim.id].verdict == "REFUTED"]

    assert len(refuted) >= 12
    assert [c.id for c in refuted if not refutes(c, committed[c.id])] == []


def cheapest_of_each_verdict():
    """One entry of each verdict that the ledger has."""
    costliest_first = sorted(load().entries, key=lambda entry: -entry.seconds)
    return list({entry.verdict: entry.id for entry in costliest_first}.values())


def test_a_selection_runs_and_agrees_with_the_committed_ledger():
    seen = []
    ids = cheapest_of_each_verdict()

    ledger = prove(ids, lambda share, entry: seen.append(share), processes=1)

    assert exit_code(ledger, load(), complete=False) == 0
    assert len(seen) == len(ledger.entries)
    assert seen == sorted(seen)
    assert seen[-1] == pytest.approx(1)


def test_patterns_beginnings_and_several_ids_select():
    assert set(selected(["authority"])) >= {"authority.shape", "authority.limit"}
    with pytest.raises(UnknownNameError, match="eq25"):
        selected(["eq2x"])
    assert set(selected(["eq8[67]"])) == {"eq86"}
    assert selected(["guard.*"]) == [key for key in selected(()) if key.startswith("guard.")]
    assert set(selected(["eq03", "eq05"])) == {"eq03", "eq05"}
    with pytest.raises(UnknownNameError):
        selected(["nothing.*"])


@pytest.mark.slow
def test_what_is_asked_for_is_printed_in_full_and_written_as_json(tmp_path, capsys):
    assert runner.run_prove(["eq25"], tmp_path / "out.json") == 0

    assert '"entries"' in (tmp_path / "out.json").read_text("utf-8")
    out = capsys.readouterr().out
    assert "eq25: PROVED" in out
    for word in ("claim:", "hypotheses:", "method:", "counterexample:", "functions:"):
        assert word in out


def test_workers_end_with_their_parent():
    """A worker ends soon after its parent is killed, although the parent cleans nothing up."""
    code = (
        "import os, sys, time; from multiprocessing import get_context;"
        "from wmr_proofs.runner import follow_parent;"
        "pid = os.fork()\n"
        "if pid == 0:\n"
        "    follow_parent(os.getppid()); time.sleep(600)\n"
        "print(pid, flush=True); time.sleep(600)"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, text=True
    ) as parent:
        worker = int(parent.stdout.readline())
        time.sleep(1)
        parent.terminate()
    for _ in range(600):
        if not is_running(worker):
            return
        time.sleep(0.1)
    raise AssertionError("the worker is still there a minute later")


def is_running(pid):
    try:
        state = Path(f"/proc/{pid}/stat").read_text("utf-8").rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


def test_exported_obligations_are_smt_lib(tmp_path):
    z3 = pytest.importorskip("z3")
    runner.run_export(tmp_path, ["guard.inside", "conditions.256", "wheels.per-wheel"])

    assert "`sat`" in (tmp_path / "README.md").read_text("utf-8")
    names = {path.name for path in (tmp_path / "guard.inside").iterdir()}
    assert {"goal-1-forwards.smt2", "domain-1-backwards.smt2", "hypotheses-forwards.smt2"} <= names
    files = list(tmp_path.rglob("*.smt2"))
    assert {path.parent.name for path in files if path.name.startswith("goal")} == {
        "guard.inside", "conditions.256", "wheels.per-wheel"
    }  # fmt: skip
    for path in files:
        solver = z3.Solver()
        solver.from_file(str(path))
        first, status, *_ = path.read_text("utf-8").splitlines()
        answer = str(solver.check())
        assert first.endswith(f"expected {answer}"), path
        assert status == f"(set-info :status {answer})"
        proved = path.parent.name == "guard.inside" and not path.name.startswith("hypotheses")
        assert answer == ("unsat" if proved else "sat")


@pytest.mark.slow
def test_a_second_solver_agrees_where_it_is_installed(monkeypatch):
    yices = second_solvers.programs().get("yices") or pytest.skip("NOT RUN: no yices")
    monkeypatch.setattr(second_solvers, "programs", lambda: {"yices": yices})
    (claim,) = (claim for claim in all_claims() if claim.id == "guard.inside")

    assert second_solvers.confirmed_by(claim.statement(CLAIMED)) == ("yices",)
    assert second_solvers.confirmed_by(claim.statement(MUTATED)) == ()


@pytest.mark.parametrize("solver", ["cvc5", "yices"])
def test_second_solvers_meet_hypotheses_at_the_recorded_point_and_not_at_another(solver):
    """A symbol may have the name of a solver's command, "push"."""
    _ = second_solvers.programs().get(solver) or pytest.skip(f"NOT RUN: no {solver}")
    module = pytest.importorskip("wmr_proofs.methods.obligations")
    (claim,) = (claim for claim in all_claims() if claim.id == "guard.monitor")
    point = load().by_id()["guard.monitor"].satisfied_at

    def said(values):
        items = module.obligations(claim.statement(CLAIMED), values)
        (text,) = (item.text for item in items if item.name == "hypotheses")
        return second_solvers.answer(solver, text)

    assert "push" in point
    assert said(point) == "sat"
    assert said(dict.fromkeys(point, "-1")) == "unsat"


def test_what_no_second_solver_closes_as_a_whole_it_closes_case_by_case():
    cases = pytest.importorskip("tests.proofs.cases").cases
    _ = second_solvers.programs().get("yices") or pytest.skip("NOT RUN: no yices")
    (claim,) = (claim for claim in all_claims() if claim.id == "strict.falls")
    claimed, mutated = (
        {second_solvers.answer("yices", text) for text in cases(claim.statement(mutation))}
        for mutation in (CLAIMED, MUTATED)
    )

    assert claimed == {"unsat"}
    assert "sat" in mutated


def test_missing_packages_are_said_and_never_proved(monkeypatch, capsys):
    monkeypatch.setattr(entries, "missing", lambda method: ("z3",) if method else ())

    assert runner.run_prove(["eq86", "eq03", "lemma.log"]) == 3
    assert "pip install" in capsys.readouterr().out


COSTLY = 0.1
"""Seconds that an entry took when it was proved anew, from which on it is proved again by the test
above alone, once its solver has another version.  While its graph is the committed one, so is what
was proved."""


def proved_again():
    """Return every EACH-th of the entries that cost less than COSTLY, to test the solvers."""
    return [entry.id for entry in load().entries if entry.seconds < COSTLY][::EACH]


@pytest.mark.slow
def test_everything_is_as_committed(monkeypatch):
    ids = proved_again()
    patterns = [f"{key[:-1]}[{key[-1]}]" for key in ids]  # each selects one alone
    search = entries.functions_of
    monkeypatch.setattr(
        entries, "functions_of", lambda claim, first=(): tuple(first) or search(claim)
    )  # functions that the ledger names, where it names some
    gc.disable()  # in another thread it would free a solver's terms while the solver works on them
    try:
        ledger = prove(patterns, processes=1)
    finally:
        gc.enable()

    assert [entry.id for entry in ledger.entries] == ids
    assert [(d.id, d.now) for d in differences(ledger, load(), complete=False)] == []
    assert stale({entry.id: entry.graph_hash for entry in ledger.entries}, load()) == []
    assert exit_code(ledger, load(), complete=False) == 0


def test_functions_that_the_ledger_names_are_where_it_says():
    named = {name for entry in load().entries for name in entry.functions}

    assert [name for name in sorted(named) if function_named(name) is None] == []
