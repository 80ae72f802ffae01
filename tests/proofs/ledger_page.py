"""The ledger as a page of the documentation.  Standard library only."""

import tomllib
from collections import Counter
from pathlib import Path

from wmr_ctrl.results.ledger import REFUTED, load
from wmr_proofs.paper import equations

HEAD = """\
# The ledger

Every claim, with its verdict. `wmr-ctrl prove` checks all of them again and compares with this
page, which is generated (`python -m tests.proofs.record`). [What is proved, and what is
not](proofs.md) says what the verdicts and methods mean. `wmr-ctrl prove --only ID` prints one entry
in full, with the functions of the product that its graph holds. Lists and tables are folded: click
on a line with a triangle to open the one below it.
"""

GUARANTEES = [
    (row["says"], row["entries"])
    for row in tomllib.loads(Path(__file__).with_name("guarantees.toml").read_text("utf-8"))[
        "guarantee"
    ]
]
"""(what is guaranteed or denied, ids of its entries)."""
COUNTEREXAMPLES = "Exact values of the inputs; with them the claim can be checked by hand.\n"
COLUMNS = "| id | eq. | claim | for a robot | verdict | how |\n|---|---|---|---|---|---|"


def page(ledger=None, stale=()):
    """Markdown of the whole ledger (the committed one by default); ``stale`` ids are marked."""
    shown, marked = ledger or load(), set(stale)
    known, counts = shown.by_id(), shown.tally().items()
    tally = ", ".join(f"{count} {verdict}" for verdict, count in counts)
    parts = [HEAD, f"{len(shown.entries)} entries: {tally}.\n", "## By equation\n"]
    parts += [_folded(f"All {len(equations())} equations", _index(shown)), "## By guarantee\n"]
    parts += ["What is not in the paper.\n", _folded("All guarantees", _guarantees(known))]
    parts += [CHAINS, _folded("All chains", _chains(known))]
    parts += [ROUNDED, _folded("All operations", _roundings(shown))]
    themes = {}
    for entry in shown.entries:
        themes.setdefault(entry.theme, []).append(entry)
    for theme, group in themes.items():
        rows = "\n".join(_row(entry, entry.id in marked) for entry in group)
        parts += [f"## {theme}\n", _folded(_counted(group), f"{COLUMNS}\n{rows}\n")]
    points = [
        f"- {entry.id}: {', '.join(f'{name} = {value}' for name, value in point.items())}\n"
        for entry in shown.entries
        if (point := entry.counterexample)
    ]
    parts += ["## Counterexamples\n", COUNTEREXAMPLES, _folded("All of them", "".join(points))]
    return "\n".join(parts)


def _folded(title, body):
    return f"<details>\n<summary>{title}</summary>\n\n{body}\n</details>\n"


def _counted(group):
    counts = Counter(entry.verdict for entry in group)
    return ", ".join(f"{count} {verdict}" for verdict, count in counts.items())


def _index(ledger):
    rows = []
    for item in equations():
        entries = [entry for entry in ledger.entries if item.number in entry.equations]
        told = [f"defined in {item.home}"] if item.role == "definition" else []
        told += [f"{entry.id} {entry.verdict}" for entry in entries]
        named = _cell(", ".join(told)) or "-"
        cells = (f"({item.number})", _cell(item.title), item.status, _cell(item.note), named)
        rows.append(f"| {' | '.join(cells)} |\n")
    head = "| eq. | what it is | status | note | entries |\n|---|---|---|---|---|\n"
    return f"{head}{''.join(rows)}"


def _guarantees(known):
    rows = "\n".join(
        f"| {_cell(what)} | {', '.join(f'{key} {known[key].verdict}' for key in ids)} |"
        for what, ids in GUARANTEES
        if all(key in known for key in ids)
    )
    return f"| what | entries |\n|---|---|\n{rows}\n"


CHAINS = """\
### What each rests on

From what is guaranteed down to what was PROVED of the product's functions, LEMMAs and arguments by
HAND; what was shown above is not repeated.
"""


def _chains(known):
    lines = []
    for what, ids in GUARANTEES:
        lines.append(f"- {what}")
        shown = set()
        for key in ids:
            lines += _chain(known, key, 1, shown)
    return "\n".join(lines) + "\n"


ROUNDED = """\
## By operation

What the compiled text computes, how far it is from the exact result or what holds of it in spite of
rounding, and the entries that use this.
"""


def _roundings(ledger):
    found = []
    for entry in ledger.entries:
        noticed = [name for name, said in entry.altered.items() if said == REFUTED]
        if ".rounding" in entry.id and noticed:
            used = [other.id for other in ledger.entries if entry.id in other.premises]
            operation = ", ".join(name.rpartition(":")[2] for name in noticed)
            cells = operation, entry.claim, entry.id, ", ".join(used) or "-"
            found.append(f"| {' | '.join(map(_cell, cells))} |\n")
    return f"| operation | bound | entry | used in |\n|---|---|---|---|\n{''.join(found)}"


def _chain(known, key, depth, shown):
    if key not in known or key in shown:
        return []
    shown.add(key)
    lines = [f"{'  ' * depth}- {key} {known[key].verdict}"]
    for premise in known[key].premises:
        lines += _chain(known, premise, depth + 1, shown)
    return lines


def _row(entry, is_stale):
    numbers = ", ".join(f"({n})" for n in entry.equations)
    claim = f"{entry.claim} [{entry.form}]" + (
        f" - *{entry.hypotheses}*" if entry.hypotheses else ""
    )
    verdict = f"**{entry.verdict}**" + (" (the graph has changed since)" if is_stale else "")
    cells = (entry.id, numbers, _cell(claim), _cell(entry.meaning), verdict, _cell(how(entry)))
    return f"| {' | '.join(cells)} |"


def how(entry):
    """Return the reason for the verdict in one phrase."""
    if entry.verdict == "HAND":
        return f"by hand, see lemmas.md{_rests(entry)}"
    if not entry.method:
        return _rests(entry).strip(" ;") or "-"
    trusted = f"; trusted: {', '.join(entry.trusted)}" if entry.trusted else ""
    if entry.certificate:
        trusted = f"; certificates of {entry.certificate['obligations']} obligations"
    second = f"; confirmed by {', '.join(entry.confirmed_by)}" if entry.confirmed_by else ""
    return f"{entry.method}{trusted}{second}{_rests(entry)}"


def _rests(entry):
    return f"; rests on {', '.join(entry.premises)}" if entry.premises else ""


def _cell(text):
    return text.replace("|", "&#124;").replace("*'", "\\*'").replace("W*", "W\\*")
