"""The picture of proved claims says no more than the committed ledger."""

import pytest

from analysis.chain import CHAINS, picture, verdicts

LINKS = [(title, link) for title, chain in CHAINS.items() for link in chain]
HOLDS = {"PROVED", "LEMMA", "HAND"}


@pytest.mark.parametrize("title, link", LINKS, ids=lambda item: getattr(item, "says", item))
def test_every_entry_of_a_link_is_there_and_holds(title, link):
    assert set(verdicts(link).values()) <= HOLDS


def test_a_chain_begins_with_its_promise_and_ends_with_what_is_trusted():
    for chain in CHAINS.values():
        assert [bool(link.patterns) for link in (chain[0], chain[1], chain[-1])] == [False] * 3
        assert sum(len(verdicts(link)) for link in chain) > 10


def test_the_picture_has_every_sentence():
    said = " ".join(" ".join(item.get_text().split()) for item in picture().axes[0].texts)

    assert [link.says for _, link in LINKS if link.says not in said] == []
