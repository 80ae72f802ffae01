"""What only a person's argument closes, and what stays open: words alone, read from manual.toml."""

from __future__ import annotations

import tomllib
from importlib.resources import files

from wmr_ctrl.proofs.claim import Claim, Claims


def _entries() -> list[Claim]:
    text = files("wmr_ctrl.proofs.claims").joinpath("manual.toml").read_text(encoding="utf-8")
    lists = ("equations", "premises")
    rows = tomllib.loads(text)["entry"]
    return [Claim(**row | {key: tuple(row.get(key, ())) for key in lists}) for row in rows]


claim = Claims(listed=_entries())
