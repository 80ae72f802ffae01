"""The ledger: entries with verdicts, their JSON, and comparison of a run with the committed one.

Standard library only, so that reports and documentation can show the committed ledger everywhere.
"""

import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

COMMITTED = Path(__file__).with_name("ledger.json")
PROVED, REFUTED, LEMMA = "PROVED", "REFUTED", "LEMMA"
HAND, OPEN, NOT_CHECKED = "HAND", "OPEN", "NOT_CHECKED"
VERDICTS = (PROVED, REFUTED, LEMMA, HAND, OPEN, NOT_CHECKED)
PUBLIC_KEYS = (
    "id", "equations", "claim", "form", "verdict", "method", "trusted", "mutation_refuted",
    "functions", "premises", "altered", "alterations", "confirmed_by", "certificate",
    "cancelled", "counterexample", "seconds", "graph_hash", "versions",
)  # fmt: skip
UNCHECKED = 3
"""Exit code of `wmr-ctrl prove` where something could not be checked."""
NOTICED = (REFUTED, OPEN)
"""Verdicts of an altered claim by which an entry notices the alteration."""


@dataclass(frozen=True)
class Entry:
    """One checked claim.

    ``equations`` are numbers of the paper; ``form`` is printed, corrected or ours.
    ``counterexample`` maps inputs of the graph to exact rationals as text (or ``1 pi``) if the
    verdict is REFUTED. ``mutation_refuted`` says whether the same method refuted the altered claim;
    ``satisfied_at`` is a point that meets the hypotheses.  ``graph_hash`` covers the graphs of
    claim and altered claim, the choice and relations of hypotheses, and the method with its regions
    and boxes; it is empty for an entry without a graph.  ``versions`` are those of the packages
    that decided; z3 is one of them if CasADi cancelled an operation.  ``altered`` has the product's
    functions in the graph, as ``module:function``, each with the entry's verdict if the function is
    altered: REFUTED, OPEN, PROVED if it makes no difference, empty if not tried yet.  ``premises``
    are entries that the claim depends on; ``confirmed_by`` are further solvers that agree.
    ``certificate`` has the number of obligations and the hash of their row in the index of
    certificates, if each of them has one; such an entry depends on no solver.  ``cancelled`` counts
    the operations that CasADi cancelled, each of which was shown to be defined; None if that was
    not shown.  ``seconds`` is processor time.
    """

    id: str
    equations: tuple[int, ...]
    claim: str
    form: str
    verdict: str
    method: str = ""
    trusted: tuple[str, ...] = ()
    mutation_refuted: bool | None = None
    counterexample: Mapping[str, str] | None = None
    seconds: float = 0.0
    graph_hash: str = ""
    meaning: str = ""
    hypotheses: str = ""
    evidence: Mapping[str, object] = field(default_factory=dict)
    satisfied_at: Mapping[str, str] | None = None
    premises: tuple[str, ...] = ()
    altered: Mapping[str, str] = field(default_factory=dict)
    confirmed_by: tuple[str, ...] = ()
    certificate: Mapping[str, object] | None = None
    cancelled: int | None = None
    theme: str = ""
    versions: Mapping[str, str] = field(default_factory=dict)

    @property
    def functions(self) -> tuple[str, ...]:
        """The product's functions whose alterations the entry notices."""
        return tuple(name for name, verdict in self.altered.items() if verdict in NOTICED)

    @property
    def alterations(self) -> dict[str, int] | None:
        """Numbers of altered functions, of REFUTED (caught) and of OPEN ones; None if not tried."""
        verdicts = [verdict for verdict in self.altered.values() if verdict]
        counts = {"caught": verdicts.count(REFUTED), "open": verdicts.count(OPEN)}
        return {"tried": len(verdicts), **counts} if verdicts else None

    def is_about(self, graph_hash: str, versions: Mapping[str, str]) -> bool:
        """True if it is about these graphs, with the same method and versions."""
        known = {name: self.versions.get(name) for name in versions}
        return (self.graph_hash, known) == (graph_hash, versions)

    def public(self) -> dict[str, object]:
        """The entry as written by `wmr-ctrl prove --json`."""
        every = asdict(self) | {"functions": self.functions, "alterations": self.alterations}
        return {key: every[key] for key in PUBLIC_KEYS}


@dataclass(frozen=True)
class Ledger:
    """All entries of one run, in the order of the claims."""

    entries: tuple[Entry, ...]

    def tally(self) -> dict[str, int]:
        """Number of entries per verdict."""
        counted = Counter(entry.verdict for entry in self.entries)
        return {verdict: counted[verdict] for verdict in VERDICTS if counted[verdict]}

    def by_id(self) -> dict[str, Entry]:
        """Entries by id."""
        return {entry.id: entry for entry in self.entries}

    def to_json(self) -> str:
        """``{"entries": [...]}`` with the public keys."""
        return json.dumps({"entries": [entry.public() for entry in self.entries]}, indent=1)

    def save(self, path: Path) -> None:
        """Write everything, to be read by `load` (the committed ledger is made so)."""
        text = json.dumps(
            {"entries": [asdict(entry) for entry in self.entries]}, indent=1, ensure_ascii=False
        )
        path.write_text(text + "\n", encoding="utf-8")


def load(path: Path = COMMITTED) -> Ledger:
    """A saved ledger; the committed one by default."""
    rows = json.loads(path.read_text(encoding="utf-8"))["entries"]
    return Ledger(tuple(_entry(row) for row in rows))


def _entry(row: Mapping[str, Any]) -> Entry:
    lists = ("equations", "trusted", "premises", "confirmed_by")
    made: dict[str, Any] = {k: tuple(v) if k in lists else v for k, v in row.items()}
    return Entry(**made)
