"""``wmr-ctrl dossier``: function, assumptions, argument and faults of one speed limit, to sign."""

import re
from collections.abc import Iterable, Iterator, Mapping
from math import ceil, isfinite
from typing import Any

from wmr_ctrl.control.controller import guard
from wmr_ctrl.control.filter import filter_system
from wmr_ctrl.control.filter.rounding_ranges import unproved_roundings
from wmr_ctrl.control.guard.bounds import STATED, assumption_sources, net, pair_of, reach
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.core.data import data
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.section import quantities
from wmr_ctrl.report.drawing import write_html
from wmr_ctrl.report.run_page import embedded
from wmr_ctrl.results import ledger, promises
from wmr_ctrl.simulation.runnable import versions
from wmr_ctrl.theory.checks import filter_facts
from wmr_ctrl.theory.checks.unknown_zero import is_guarded, zeros
from wmr_ctrl.theory.door import proofs
from wmr_ctrl.world.scenario import scenario_hash
from wmr_ctrl.world.scenario.toml_io import notes

from .check_sentences import promise

TABLES = data(__package__, "dossier.toml")
NOT_SHOWN, RESTS = "not shown", "What these rest on."
SOURCE = re.compile(
    r"(^|[;,] )(from |source: |maker's |data sheet)|\.(ya?ml|urdf|xacro|csv|mcap|bag|pdf)\b"
)
"""Marks of a comment that names a source."""
COVERED = ("wmr_ctrl.control.guard.", "wmr_ctrl.control.filter.")
"""Modules whose functions an argument is about."""
HOLDS = (ledger.PROVED, ledger.LEMMA, ledger.HAND)


def kind_of(setup: Setup) -> str:
    """Kind of promise of a scenario: "guard", "clip", "governor", "band", "loops" or "slew"."""
    own = setup.scenario.filter
    if not setup.takes_velocity:
        return "guard"
    if own.kind != "clip" or set(own.loop) == {"first-order"}:
        return own.kind
    return "loops" if own.slew is None else "slew"


def document(setup: Setup, source: str) -> dict[str, object]:
    """All contents of the page, as ``--json`` prints them; ``source`` names the scenario's file.

    Raises ArgumentError if nothing is promised, or a claim differs from the committed ledger.
    """
    _refuse(setup)
    case, links = setup.scenario, promises.chain(kind_of(setup))
    said, known = [link.says for link in links], ledger.load().by_id()
    argument = list(_argument(links, known))
    covered = {name for row in argument for name in known[row["claim"]].functions}
    outside = [row["text"] for row in _rows("outside", setup)]
    outside += [sentence for _, sentence in unproved_roundings(case)]
    if others := sorted(_functions(setup) - covered):
        outside.append(f"In no entry above, of guard and filter alone: {', '.join(others)}.")
    return {
        "scenario": case.name, "kind": kind_of(setup), "hash": scenario_hash(case),
        "read_first": TABLES["read_first"],
        "function": promise(setup),
        "assumptions": list(assumptions(setup, source)),
        "promise": [*said[:-1], RESTS, said[-1]], "argument": argument,
        "response": list(responses(setup)), "not_covered": outside,
        "faults": [
            row | {"claims": promises.Link("", tuple(row["claims"])).ids(known)}
            for row in _rows("fault", setup)
        ],
        "informative": TABLES["informative"], "versions": versions(),
    }  # fmt: skip


def write(document: Mapping[str, object], source: str, path: str) -> None:
    """Write the page into an .html file, atomically; errors as `write_html`."""
    said: dict[str, Any] = {**document}
    write_html(path, "dossier.html.j2", **said, file=source, document=embedded(document))


def _refuse(setup: Setup) -> None:
    facts = filter_facts(setup)
    broken = list(facts.broken) if facts else [setup.void] if setup.void else []
    if not is_guarded(setup):
        broken = [promise(setup)]
    elif found := zeros(setup):
        broken += [f"{row.key} is 0, as if {row.words}: state {row.remedy}." for row in found]
    if broken:
        raise ArgumentError(
            f"{setup.scenario.name}: there is no promise to sign for. {' '.join(broken)}"
        )


def _rows(table: str, setup: Setup) -> Iterator[dict[str, Any]]:
    """Rows that concern this promise, its loops and its options."""
    of, own = kind_of(setup), setup.scenario.filter
    for row in TABLES[table]:
        loops = row.get("loop", own.loop[0]) in own.loop
        if of in row["of"] and loops and ("needs" not in row or getattr(own, row["needs"])):
            yield {key: value for key, value in row.items() if key not in ("of", "loop", "needs")}


def assumptions(setup: Setup, source: str) -> Iterator[dict[str, object]]:
    """Rows of the promise's assumptions, each with the source that the scenario's file names."""
    case, beside = setup.scenario, notes(source)
    derived = assumption_sources(case, setup.guard, setup.effects)
    for row in _rows("assumption", setup):
        table, _, name = (key := row["key"]).partition(".")
        section = setup.guard if table == "guard" else case.table(table)
        value = getattr(section, name)
        if value is None:
            continue
        fields = dict(quantities(type(section)))
        told, parts = beside.get(key, ""), derived[name].sources if name in derived else ()
        if table == "guard" and parts and STATED not in parts:
            told = f"derived from {', '.join(parts)}"
        shown = key not in case.assumed and SOURCE.search(told)
        meant = {"unit": fields[name].unit, "meaning": fields[name].doc} if name in fields else {}
        origin = told if shown else f"{NOT_SHOWN}: {told}" if told else NOT_SHOWN
        yield row | meant | {"value": value, "source": origin}
    for row in _rows("general", setup):
        yield {"key": "", "value": None, "unit": "", "source": NOT_SHOWN} | row


def _argument(
    links: Iterable[promises.Link], entries: Mapping[str, ledger.Entry]
) -> Iterator[dict[str, Any]]:
    """The links' entries, and the entries that these depend on.

    Raises ArgumentError if one does not hold, or is about another graph.
    """
    claims = {claim.id: claim for claim in proofs("claims").all_claims()}
    found = dict[str, str]()
    for link in links:
        found = dict.fromkeys(link.ids(entries), link.says) | found
    rest = [*found]
    while rest:
        further = [key for key in entries[rest.pop()].premises if key not in found]
        found |= dict.fromkeys(further, RESTS)
        rest += further
    hashes = {key: proofs("entry").graph_hash(claims[key]) for key in found}
    mine = ledger.Ledger(tuple(entries[key] for key in found))
    wrong = {key for key in found if entries[key].verdict not in HOLDS}
    wrong.update(proofs("comparison").stale(hashes, mine))
    if wrong:
        raise ArgumentError(
            f"The argument rests on {', '.join(sorted(wrong))}, which the committed ledger does "
            "not show for the graphs of today. `wmr-ctrl prove` says what holds."
        )
    for key, says in found.items():
        entry = entries[key]
        yield {
            "claim": key, "verdict": entry.verdict, "by_hand": entry.verdict == ledger.HAND,
            "graph_hash": entry.graph_hash, "premises": list(entry.premises), "says": says,
            "words": entry.claim, "if": entry.hypotheses, "method": entry.method,
            "confirmed_by": list(entry.confirmed_by),
        }  # fmt: skip


def _functions(setup: Setup) -> set[str]:
    """The guard's or filter's functions that run while this scenario's graph is built."""
    proofs("claims").forget()
    called: Iterable[str] = proofs("alterations").functions_called(
        lambda: filter_system(setup.scenario) if setup.takes_velocity else guard(setup)
    )
    return {name for name in called if name.startswith(COVERED)}


def responses(setup: Setup) -> Iterator[dict[str, object]]:
    """Rows of events and reactions with their times [s]; None for unstated times."""
    times = _of_guard(setup) if kind_of(setup) == "guard" else _of_filter(setup)
    for row in _rows("response", setup):
        yield row | {"seconds": times.get(row["seconds"])}


def _of_filter(setup: Setup) -> dict[str, float | None]:
    """Times [s] by the names of the table; a band's steps may be off their beat by twice the
    jitter.
    """
    own, period = setup.scenario.filter, setup.scenario.clock.control
    latest = max(most for _, most in own.intervals("delay"))
    off = own.jitter * (2 if own.kind == "band" else 1 + own.losses)
    node = data("wmr_ctrl.ros2", "parameters.toml")["filter"]["command_timeout"]["default"]
    return {
        "sent": period + max(own.jitter, period / 4),
        "acts": latest + (1 + own.losses) * period + off,
        "age": own.age, "at_once": 0.0, "hold": own.hold or None,
        "command_timeout": node + period + own.jitter,
    }  # fmt: skip


def _of_guard(setup: Setup) -> dict[str, float | None]:
    """Times [s] by the names of the table; some exist only if nothing is late."""
    case, numbers, period = setup.scenario, setup.guard, setup.scenario.clock.control
    back = list[float]()
    for i in (0, 1):
        brakes = min(pair_of(numbers.brake)[i], reach(case, numbers, i) - net(numbers, i))
        spare = period * (brakes - pair_of(numbers.dbar)[i])
        beyond = 0.1 * case.limits.v_u1[i] * pair_of(numbers.M_max)[i]
        back += [period * ceil(beyond / spare)] if spare > 0 else []
    timely = not any(item.most for item in numbers.lateness(case.clock))
    known = timely and isfinite(setup.tau_max) and len(back) > 1
    return {
        "acts": period + numbers.latest, "shown": 2 * period if timely else None,
        "back": max(back) if known else None,
    }  # fmt: skip
