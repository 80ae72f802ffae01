"""Pages with generated parts; each part is between two marks with its name."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.results import atomic_text


def page_parser(description: str | None, quick: str) -> argparse.ArgumentParser:
    """Argument parser of a benchmark that renews a part of a page; ``quick``: help of --quick."""
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help=quick)
    parser.add_argument("--out", type=Path, help="page whose part is renewed")
    return parser


def renew(page: Path, name: str, text: str) -> None:
    """Put ``text`` between the marks of ``name``; ArgumentError if the page has none."""
    whole = page.read_text(encoding="utf-8")
    begin, end = (f"<!-- {word} {name} -->" for word in ("begin", "end"))
    head, first, rest = whole.partition(begin)
    _, second, tail = rest.partition(end)
    if not (first and second):
        raise ArgumentError(f"{page}: it has no part between '{begin}' and '{end}'.")
    with atomic_text(page) as file:
        file.write(f"{head}{begin}\n\n{text}\n\n{end}{tail}")


def millimetres(length: float) -> str:
    """Certified length [m] in mm, rounded up."""
    return f"{math.ceil(1e5 * length * (1 - 1e-12)) / 100:.2f}"
