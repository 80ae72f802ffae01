"""Pages of the documentation, and their blocks of code with the output that a page shows.

A comment in the line above a block says how it is treated.  ``<!-- file: NAME -->`` writes it to
that file, ``<!-- exit: N -->`` expects another exit code than 0, ``<!-- not tried here: WHY -->``
does not run it, ``<!-- slow -->`` runs it only in slow tests, and ``<!-- tried by PATH -->`` names
the test that runs it instead.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
BLOCK = re.compile(
    r"^(?:<!-- (?P<mark>[^>]*?) -->\n)?```(?P<language>[\w{}-]*)[^\n]*\n(?P<text>.*?)^```$",
    re.M | re.S,
)
RUN = ("console", "python")
"""Languages that are run."""


@dataclass(frozen=True)
class Block:
    """A fenced block: its line, language, text, and the comment above it."""

    line: int
    language: str
    text: str
    mark: str

    @property
    def file(self):
        """Name of the file to write it to, or nothing."""
        return self.mark.removeprefix("file: ") if self.mark.startswith("file: ") else ""

    @property
    def exit_code(self):
        """Expected exit code of its commands."""
        return int(self.mark.removeprefix("exit: ")) if self.mark.startswith("exit: ") else 0

    @property
    def tried(self):
        """True if it is run with its page."""
        left_alone = self.mark == "slow" or self.mark.startswith(("not tried", "tried by"))
        return self.language in RUN and not left_alone

    @cached_property
    def commands(self):
        """Commands after ``$ ``, each with the output that the page shows."""
        parts = re.split(r"^\$ ", self.text, flags=re.M)[1:]
        lines = [part.partition("\n") for part in parts]
        return [(command, output) for command, _, output in lines]


@dataclass(frozen=True)
class Page:
    """A Markdown file of the tree."""

    path: Path

    @property
    def name(self):
        """Path below the root."""
        return self.path.relative_to(ROOT).as_posix()

    @cached_property
    def text(self):
        """Whole text of the page."""
        return self.path.read_text("utf-8")

    @cached_property
    def blocks(self):
        """Its blocks in order."""
        return [
            Block(
                self.text.count("\n", 0, m.start()) + 1, m["language"], m["text"], m["mark"] or ""
            )
            for m in BLOCK.finditer(self.text)
        ]

    @cached_property
    def prose(self):
        """The text without its blocks."""
        return BLOCK.sub("", self.text)


def pages():
    """Every page that people read: the site's, and those at the root and in folders."""
    others = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")]
    others += [ROOT / folder / "README.md" for folder in ("analysis", "benchmarks", "fmu")]
    return [Page(path) for path in (*sorted(DOCS.rglob("*.md")), *others) if path.exists()]


def written_pages():
    """Pages written by hand, with blocks to run: neither notebooks nor the ledger."""
    made = ("docs/notebooks/", "docs/ledger.md")
    return [page for page in pages() if not page.name.startswith(made)]
