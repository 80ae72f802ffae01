"""Arguments for each promise: sentences, and the ledger's entries that they summarise."""

from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase

from wmr_ctrl.core.data import data

from .ledger import Entry


@dataclass(frozen=True)
class Link:
    """A sentence, and patterns of its entries' ids; a pattern with a minus excludes entries."""

    says: str
    patterns: tuple[str, ...] = ()

    def ids(self, known: Mapping[str, Entry]) -> list[str]:
        """Ids of its entries, in the order of the ledger; LookupError if a pattern matches none."""
        found: dict[str, None] = {}
        for pattern in self.patterns:
            matching = [key for key in known if fnmatchcase(key, pattern.lstrip("-"))]
            if not matching:
                raise LookupError(f"no entry of the ledger is called {pattern}")
            if pattern.startswith("-"):
                found = {key: None for key in found if key not in matching}
            else:
                found |= dict.fromkeys(matching)
        return list(found)


def chain(name: str) -> tuple[Link, ...]:
    """Links of a promise, from the promise itself down to what is trusted."""
    return tuple(
        Link(row["says"], tuple(row["entries"]))
        for row in data(__package__, "promises.toml")[name]["links"]
    )
