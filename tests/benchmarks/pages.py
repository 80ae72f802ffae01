"""Tables on the pages that benchmarks write."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
RESULTS = (ROOT / "benchmarks" / "results.md").read_text("utf-8")
MATCH = (ROOT / "docs" / "match.md").read_text("utf-8")


def table(page, name):
    """Cells of the head and of every row of a part of a page."""
    part = page.partition(f"<!-- begin {name} -->")[2].partition(f"<!-- end {name} -->")[0]
    lines = [line for line in part.splitlines() if line.startswith("|") and set(line) - set("|-: ")]
    return [cells(line) for line in lines]


def cells(line):
    return [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
