"""A page with parts that commands write: each stands between two marks of its name."""

from __future__ import annotations

from pathlib import Path

from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.results import atomic_text


def renew(page: Path, name: str, text: str) -> None:
    """Put ``text`` between the marks of ``name``; ArgumentError where the page has none."""
    whole = page.read_text(encoding="utf-8")
    begin, end = (f"<!-- {word} {name} -->" for word in ("begin", "end"))
    head, first, rest = whole.partition(begin)
    _, second, tail = rest.partition(end)
    if not (first and second):
        raise ArgumentError(f"{page}: it has no part between '{begin}' and '{end}'.")
    with atomic_text(page) as file:
        file.write(f"{head}{begin}\n\n{text}\n\n{end}{tail}")
