"""Universal binaries of macOS: several libraries in one file, each for its own processor.

Some tools look for an Apple processor's library in FMI 2's folder darwin64; a universal one serves
them and Intel alike.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

MAGIC = 0xCAFEBABE
_ALIGNMENT = 14  # of each slice, as a power of two: 16 KiB pages


def joined(libraries: Sequence[bytes]) -> bytes:
    """One universal library of Mach-O libraries; a single one stays as it is."""
    if len(libraries) == 1:
        return libraries[0]
    page = 1 << _ALIGNMENT
    header, body, offset = struct.pack(">II", MAGIC, len(libraries)), b"", page
    for library in libraries:
        cpu, subtype = struct.unpack_from("<II", library, 4)
        header += struct.pack(">IIIII", cpu, subtype, offset, len(library), _ALIGNMENT)
        padded = library + b"\0" * (-len(library) % page)
        body += padded
        offset += len(padded)
    return header + b"\0" * (page - len(header)) + body
