"""Tables in Markdown, cell by cell from plain values."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Markdown table; cells may contain Markdown, but no line breaks."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(map(_cell, line)) + " |" for line in lines)


def _cell(text: str) -> str:
    return " ".join(text.replace("|", "\\|").split())


def code(text: str) -> str:
    """Text in code marks; "" for an empty text."""
    return f"`{text}`" if text else ""


def number(value: object) -> str:
    """Default value in TOML."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return f"[{', '.join(map(number, value))}]"
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else str(value)
    return f'"{value}"' if isinstance(value, str) else str(value)
