"""Is an ELF library complete?  A compiler on a full disk may write half of it and say nothing.

Loading such a file ends the process (SIGBUS) instead of raising, so it is looked at before it is
kept.  Only ELF files are looked into; others count as whole unless they are empty.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class _Class:
    """Where an ELF file of 32 or 64 bits keeps what is needed here: formats, and byte offsets."""

    tables: str
    """From byte 24 on: entry, offset of segments, of sections, flags, then six counts."""
    word: str
    offset: int
    size: int


_CLASSES = {1: _Class("IIIIHHHHHH", "I", 4, 16), 2: _Class("QQQIHHHHHH", "Q", 8, 32)}


def is_complete(library: Path) -> bool:
    """Whether all tables and segments that the file announces are within it."""
    content = library.read_bytes()
    if not content.startswith(b"\x7fELF"):
        return bool(content)
    try:
        return max(_ends(content)) <= len(content)
    except (struct.error, KeyError, IndexError):
        return False


def _ends(content: bytes) -> Iterator[int]:
    """Where the tables and segments of an ELF file end."""
    kind, order = _CLASSES[content[4]], "<" if content[5] == 1 else ">"
    found = struct.unpack_from(order + kind.tables, content, 24)
    segments, sections, (segment_size, count, section_size, section_count) = (
        found[1],
        found[2],
        found[5:9],
    )
    yield segments + segment_size * count
    yield sections + section_size * section_count
    for k in range(count):
        at = segments + k * segment_size
        (offset,) = struct.unpack_from(order + kind.word, content, at + kind.offset)
        (size,) = struct.unpack_from(order + kind.word, content, at + kind.size)
        yield offset + size
