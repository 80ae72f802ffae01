"""What a package takes of a Cortex-M4F: code, stack, instructions; measured, and recorded.

The GNU Arm compiler tells size and frames; an emulated board tells instructions and the deepest
stack of ten seconds of closed loop, where it has run the package.  A record counts only for the
kernel that it was made with, known by its number of operations: a scenario may ask for another one.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

RECORD = Path(__file__).parent / "templates" / "footprint.json"


@dataclass(frozen=True)
class Footprint:
    """Bytes of code with constants, of writable data and of stack; instructions of a sample.

    ``stack`` is the sum of the frames of the package's own functions, without libm's;
    ``deepest`` is what was in use on the board, libm and caller included.  ``instructions`` is the
    median, ``most_instructions`` the slowest sample.  None: it was not run there.
    """

    operations: int
    code: int
    data: int
    stack: int
    deepest: int | None
    instructions: int | None
    most_instructions: int | None
    compiler: str

    def as_mapping(self) -> Mapping[str, Any]:
        """The numbers by name."""
        return asdict(self)


def known_footprint(law: str, float32: bool, guarded: bool, operations: int) -> Footprint | None:
    """The recorded footprint of a law's package, None where none was measured."""
    listed = (Footprint(**item) for item in _record().get(key(law, float32, guarded), ()))
    return next((item for item in listed if item.operations == operations), None)


def key(law: str, float32: bool, guarded: bool = False) -> str:
    """Name under which a package's footprints are recorded, one for each form of its kernel."""
    return f"{law}-{'float32' if float32 else 'double'}{'-guard' if guarded else ''}"


@cache
def _record() -> dict[str, list[dict[str, Any]]]:
    if not RECORD.is_file():
        return {}
    loaded: dict[str, list[dict[str, Any]]] = json.loads(RECORD.read_text(encoding="utf-8"))
    return loaded
