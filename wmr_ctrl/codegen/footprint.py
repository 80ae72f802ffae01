"""Code size and stack of the packages, as measured with the GNU Arm compiler for a Cortex-M4F."""

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
    """Bytes of code with constants, of writable data, of stack; and with what they were measured.

    ``stack`` is the deepest frame of the package's own functions, without libm's.
    """

    code: int
    data: int
    stack: int
    compiler: str

    def as_mapping(self) -> Mapping[str, Any]:
        """The numbers by name."""
        return asdict(self)


def known_footprint(law: str, float32: bool) -> Footprint | None:
    """The recorded footprint of a law's package, None where none was measured."""
    found = _record().get(key(law, float32))
    return Footprint(**found) if found else None


def key(law: str, float32: bool) -> str:
    """Name under which a package's footprint is recorded."""
    return f"{law}-{'float32' if float32 else 'double'}"


@cache
def _record() -> dict[str, Any]:
    if not RECORD.is_file():
        return {}
    loaded: dict[str, Any] = json.loads(RECORD.read_text(encoding="utf-8"))
    return loaded
