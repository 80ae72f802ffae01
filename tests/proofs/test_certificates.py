"""The committed certificates match today's obligations and are accepted; gaps are named."""

import re
from pathlib import Path

import pytest

from tests.proofs.record import COUNTING, certified
from tests.proofs.test_checker import said
from wmr_ctrl.results.ledger import load
from wmr_proofs.certificates import FOLDER, differing, index, with_certificate, words_hash
from wmr_proofs.check import digest
from wmr_proofs.claims import all_claims

ROOT = Path(__file__).parents[2]
CLAIMS = {claim.id: claim for claim in all_claims()}
ENTRIES = load().by_id()
REMEDY = "python -m wmr_proofs.find "
PROMISES = (
    "guard.lemma", "guard.delay.lemma", "guard.late.lemma", "guard.varying.lemma",
    "guard.promise", "filter.clip", "filter.induction",
    "filter.peak-gain", "thm1.velocity", "prox.optimal", "eq17-18",
)  # fmt: skip
"""Guard, clip, governor, the model-based law's V1' <= -rho V1, and the minimiser."""
BUILT = ("guard.inside", "guard.feasible", "prox.inside")
"""Entries whose obligations the default tests build from the graphs."""


def behind(ids):
    """These entries and all that they depend on."""
    found = {}
    todo = list(ids)
    while todo:
        entry = ENTRIES[todo.pop()]
        if entry.id not in found:
            found[entry.id] = entry
            todo += entry.premises
    return found


def by_z3(entry):
    return re.search(r"\bZ3\b", entry.method) is not None


@pytest.mark.slow
def test_all_certificates_are_checked_with_the_standard_library_alone():
    code, text = said(FOLDER)

    assert code == 0, text
    whole, rest = re.fullmatch(
        r"(\d+) entries whole, (\d+) without certificate", text.splitlines()[-1]
    ).groups()
    assert int(whole) == sum(1 for entry in ENTRIES.values() if entry.certificate)
    assert int(whole) + int(rest) == len(index())


def test_entries_say_what_the_index_says():
    for key, row in index().items():
        rows = row["obligations"]
        whole = {"obligations": len(rows), "sha256": digest(rows)}
        assert ENTRIES[key].certificate == (whole if all(item[3] for item in rows) else None), key
        if ENTRIES[key].certificate:
            assert ENTRIES[key].trusted == ("certificate",), key
            assert not ENTRIES[key].confirmed_by, key
    assert [e.id for e in ENTRIES.values() if e.certificate and e.id not in index()] == []


def test_every_file_of_certificates_has_a_row():
    files = {path.name.removesuffix(".json.xz") for path in FOLDER.glob("*.json.xz")}

    assert files - index().keys() == set()


def test_the_index_is_about_what_the_claims_say():
    others = [key for key, row in index().items() if row["claim"] != words_hash(CLAIMS[key])]

    assert others == [], f"say it of today's words: {REMEDY}{' '.join(others)}"


@pytest.mark.parametrize("key", BUILT)
def test_obligations_are_those_of_the_graphs_of_today(key):
    assert differing(CLAIMS[key], ENTRIES[key]) == [], REMEDY + key


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_all_obligations_are_those_of_the_graphs_of_today():
    others = [key for key in index() if differing(CLAIMS[key], ENTRIES[key])]

    assert others == [], REMEDY + " ".join(others)


def test_every_proved_entry_of_the_index_has_goals_and_a_point():
    for key, row in index().items():
        names = {(item[0].split("-")[0], item[1]) for item in row["obligations"]}
        wanted = {("hypotheses", "sat")}
        wanted |= {("goal", "sat" if row["verdict"] == "REFUTED" else "unsat")}
        assert wanted <= names, key
        assert row["verdict"] == ENTRIES[key].verdict, key


def test_an_entry_rests_on_certificates_where_all_its_obligations_have_one():
    key = "guard.inside"
    found = with_certificate(CLAIMS[key], ENTRIES[key])

    assert found.certificate == ENTRIES[key].certificate


def test_what_promises_rest_on_has_certificates_or_is_named():
    text = " ".join((ROOT / "docs" / "proofs.md").read_text("utf-8").split())
    said = re.search(r"no certificate is known: (.*?)\.\s", text)
    named = set(re.split(r",\s+|\s+and\s+", said[1])) if said else set()
    without = {e.id for e in behind(PROMISES).values() if by_z3(e) and not e.certificate}

    assert named == without


def test_the_pages_say_how_many_entries_have_certificates():
    for path in COUNTING:
        assert certified(load()) in path.read_text("utf-8"), path
