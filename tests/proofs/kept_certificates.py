"""Writes the committed certificates and their index."""

import json
import lzma

from wmr_proofs.certificates import FOLDER, INDEX, index
from wmr_proofs.check import digest


def words_hash(claim):
    """SHA-256 of a claim's words."""
    return digest([claim.claim, claim.hypotheses, claim.meaning])


def save(row, certificates):
    """Replace an entry's row and its file."""
    FOLDER.mkdir(exist_ok=True)
    path = FOLDER / f"{row['id']}.json.xz"
    path.unlink(missing_ok=True)
    if certificates:
        text = json.dumps(certificates, separators=(",", ":"))
        path.write_bytes(lzma.compress(text.encode(), preset=6 | lzma.PRESET_EXTREME))
    index.cache_clear()
    save_index({**index(), row["id"]: row})


def forget_others(known):
    """Drop the certificates of entries that no longer exist."""
    gone = [key for key in index() if key not in known]
    for key in gone:
        (FOLDER / f"{key}.json.xz").unlink(missing_ok=True)
    if gone:
        save_index({key: row for key, row in index().items() if key in known})


def save_index(rows):
    """Write the index, one row a line, in the order of their ids."""
    lines = ",\n".join(json.dumps(rows[key]) for key in sorted(rows))
    (FOLDER / INDEX).write_text(f"[\n{lines}\n]\n", encoding="utf-8")
    index.cache_clear()
