"""The committed certificates: the index from claims to obligations, and a packed file for each
claim.
"""

import json
import lzma
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from wmr_ctrl.results.ledger import REFUTED, Entry

from .cancelled import cancelled_obligations
from .check import digest, unpacked
from .claim import CLAIMED, Claim
from .methods import spec
from .methods.obligations import Obligation, of_entry

FOLDER = Path(__file__).with_name("certificates")
INDEX = "index.json"
Row = Mapping[str, Any]


def obligations_of(claim: Claim, entry: Entry) -> Iterator[Obligation]:
    """All obligations that z3 was asked for an entry's verdict; empty if z3 was not asked."""
    if claim.statement is None or not isinstance(claim.method, spec.Z3):
        return
    yield from of_entry(claim.statement(CLAIMED), entry)
    if entry.verdict != REFUTED and entry.cancelled != 0:
        yield from cancelled_obligations(claim)


@cache
def index() -> dict[str, Row]:
    """The committed rows by id."""
    path = FOLDER / INDEX
    return {row["id"]: row for row in unpacked(path)} if path.exists() else {}


def with_certificate(claim: Claim, entry: Entry) -> Entry:
    """The entry, which relies on certificates alone if all of its obligations have one."""
    row = index().get(claim.id)
    found = _whole(row) if row and not differing(claim, entry) else None
    trusted = ("certificate",) if found else spec.trusted(claim.method) if claim.method else ()
    confirmed = () if found else entry.confirmed_by
    return replace(entry, certificate=found, trusted=trusted, confirmed_by=confirmed)


def _whole(row: Row) -> dict[str, Any] | None:
    """Number of obligations and hash of their row, if all of them have certificates."""
    rows = row["obligations"]
    if not all(item[3] for item in rows):
        return None
    return {"obligations": len(rows), "sha256": digest(rows)}


def differing(claim: Claim, entry: Entry) -> list[str]:
    """Names of obligations that today differ from those in the index, or are missing there."""
    row = index().get(claim.id, {"obligations": []})
    known = {tuple(item[:3]) for item in row["obligations"]}
    items = obligations_of(claim, entry)
    today = {(item.name, item.wanted, digest(item.file(claim.id))) for item in items}
    return sorted({name for name, *_ in known ^ today})


def held(key: str) -> dict[str, Any]:
    """Texts and certificates of an entry by obligation, as committed."""
    path = FOLDER / f"{key}.json.xz"
    return dict(unpacked(path)) if path.exists() else {}


def words_hash(claim: Claim) -> str:
    """SHA-256 of a claim's words."""
    return digest([claim.claim, claim.hypotheses, claim.meaning])


def save(row: dict[str, Any], certificates: Mapping[str, Any]) -> None:
    """Replace an entry's row and its file."""
    path = FOLDER / f"{row['id']}.json.xz"
    path.unlink(missing_ok=True)
    if certificates:
        text = json.dumps(certificates, separators=(",", ":"))
        path.write_bytes(lzma.compress(text.encode(), preset=6 | lzma.PRESET_EXTREME))
    save_index({**index(), row["id"]: row})


def save_index(rows: Mapping[str, Row]) -> None:
    """Write the index, one row a line, in the order of their ids."""
    lines = ",\n".join(json.dumps(rows[key]) for key in sorted(rows))
    (FOLDER / INDEX).write_text(f"[\n{lines}\n]\n", encoding="utf-8")
    index.cache_clear()
