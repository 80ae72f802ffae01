"""The list of altered places fits the present product."""

from tests.altered_files import ALTERED_FILES, NOT_NOTICED, PROVE, ROOT
from wmr_ctrl.results.ledger import load


def test_every_altered_place_is_in_its_file():
    rows = (*ALTERED_FILES, *NOT_NOTICED)
    texts = {row.path: (ROOT / row.path).read_text(encoding="utf-8") for row in rows}

    assert [(row.path, row.old) for row in rows if row.old not in texts[row.path]] == []
    assert all(row.old != row.new for row in rows)


def test_every_altered_place_has_a_test_or_an_entry():
    entries = load().by_id()
    for row in ALTERED_FILES:
        if row.tests.startswith(PROVE):
            assert entries[row.tests.removeprefix(PROVE)].verdict == "PROVED"
            continue
        for test in row.tests.split():
            path, _, name = test.partition("::")
            text = (ROOT / path).read_text(encoding="utf-8")
            assert not name or f"def {name.split('[')[0]}(" in text, test
