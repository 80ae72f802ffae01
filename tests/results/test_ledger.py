"""The ledger as data: keys, comparison, exit codes, page. No proving package is needed."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

from tests.proofs.ledger_page import GUARANTEES, page
from wmr_ctrl.results.ledger import PUBLIC_KEYS, VERDICTS, Entry, Ledger, load
from wmr_proofs.comparison import differences, exit_code
from wmr_proofs.paper import equations

ROOT = Path(__file__).parents[2]
ONE = Entry("a", (1,), "claim", "printed", "PROVED", graph_hash="00")


@pytest.mark.slow
def test_round_trip(tmp_path):
    load().save(tmp_path / "ledger.json")

    assert load(tmp_path / "ledger.json") == load()


def test_public_json_has_the_stated_keys():
    rows = json.loads(load().to_json())["entries"]

    assert all(tuple(row) == PUBLIC_KEYS for row in rows)
    assert {row["verdict"] for row in rows} <= set(VERDICTS)
    assert all(isinstance(row["equations"], list) for row in rows)


@pytest.mark.parametrize(
    "verdict, code", [("PROVED", 0), ("REFUTED", 1), ("OPEN", 1), ("NOT_CHECKED", 3)]
)
def test_exit_codes(verdict, code):
    assert exit_code(Ledger((replace(ONE, verdict=verdict),)), Ledger((ONE,))) == code


def test_a_missing_or_new_entry_is_a_difference_only_in_a_complete_run():
    two = replace(ONE, id="b")

    assert [d.id for d in differences(Ledger((ONE,)), Ledger((ONE, two)))] == ["b"]
    assert [d.id for d in differences(Ledger((ONE, two)), Ledger((ONE,)))] == ["b"]
    assert differences(Ledger((ONE,)), Ledger((ONE, two)), complete=False) == []


def test_every_identity_and_inequality_has_an_entry():
    spoken_for = {number for entry in load().entries for number in entry.equations}

    assert spoken_for == {item.number for item in equations()}


def test_proved_entries_are_backed():
    for entry in load().entries:
        if entry.verdict in ("PROVED", "LEMMA"):
            assert entry.mutation_refuted, entry.id
            assert entry.satisfied_at is not None, entry.id
            assert entry.trusted, entry.id
            assert len(entry.graph_hash) == 64, entry.id
            assert bool(entry.altered) == (entry.verdict == "PROVED"), entry.id
            assert entry.functions or entry.verdict == "LEMMA", entry.id
        if entry.verdict == "REFUTED":
            assert entry.counterexample, entry.id


def test_uses_name_entries_and_hand_entries_have_their_argument():
    known = load().by_id()
    lemmas = (ROOT / "docs" / "lemmas.md").read_text("utf-8")
    for entry in known.values():
        assert set(entry.premises) <= set(known), entry.id
        if entry.verdict == "HAND":
            assert f"## {entry.id}\n" in lemmas, entry.id


def test_guarantees_name_entries():
    known = load().by_id()

    assert [key for _, ids in GUARANTEES for key in ids if key not in known] == []


def test_page_is_current():
    assert (ROOT / "docs" / "ledger.md").read_text("utf-8") == page()


def test_page_marks_stale_entries():
    entry = load().entries[0]

    assert "the graph has changed" in page(stale=[entry.id])


def test_the_page_of_proofs_names_what_rests_on_z3_alone():
    text = (ROOT / "docs" / "proofs.md").read_text("utf-8")
    said = re.search(r"rest on z3 alone: (.*?)\.\s", " ".join(text.split()))
    named = set(re.split(r",\s+|\s+and\s+", said[1])) if said else set()

    assert named == {
        entry.id
        for entry in load().entries
        if entry.verdict in ("PROVED", "LEMMA")
        and entry.trusted == ("z3",)
        and not entry.confirmed_by
    }
