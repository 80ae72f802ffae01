"""Claims by theme, in the order of the ledger."""

import tomllib
from dataclasses import replace
from functools import lru_cache
from importlib import import_module
from importlib.resources import files
from typing import Any

from wmr_proofs.claim import Claim

BY_HAND = "Arguments by hand, assumptions, open ends"


@lru_cache(maxsize=1)
def all_claims() -> tuple[Claim, ...]:
    """Every claim, with its theme."""
    found, by_hand = list[Claim](), _by_hand()
    for theme in _tables("themes", "theme"):
        title = theme["title"]
        for place in theme["claims"]:
            file, _, name = place.partition(":")
            claims = vars(import_module(f"wmr_proofs.claims.{file}"))[name or "claim"]
            found += [replace(claim, theme=title) for claim in claims.listed]
        found += [claim for claim in by_hand if claim.theme == title and claim not in found]
    return *found, *(claim for claim in by_hand if claim.theme == BY_HAND)


def forget() -> None:
    """Drop graphs that were kept, after a change of the product's functions in memory."""
    from .network import network_axis

    network_axis.cache_clear()


def _by_hand() -> list[Claim]:
    """Claims argued by hand, and open ones: words alone."""
    lists, found = ("equations", "premises"), _tables("by_hand", "entry")
    rows = (row | {key: tuple(row.get(key, ())) for key in lists} for row in found)
    return [Claim(**{"theme": BY_HAND, **row}) for row in rows]


def _tables(file: str, name: str) -> list[dict[str, Any]]:
    """Tables of this name in a file beside this one."""
    text = files("wmr_proofs.claims").joinpath(f"{file}.toml").read_text(encoding="utf-8")
    found: list[dict[str, Any]] = tomllib.loads(text)[name]
    return found
