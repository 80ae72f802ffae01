"""Results of ``wmr-ctrl check``: predictions from theory and the findings of one run."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from itertools import groupby
from math import inf
from operator import attrgetter
from typing import NamedTuple, TypeVar

from wmr_ctrl import api
from wmr_ctrl.control.controller import lacking
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.core.errors import ArgumentError, CompilerError
from wmr_ctrl.core.fields.units import rounded
from wmr_ctrl.report.run_rows import rows_of
from wmr_ctrl.results import Run, driving, summary
from wmr_ctrl.results.measures import guard_share, tracking
from wmr_ctrl.results.remarks import Remark
from wmr_ctrl.theory import checks
from wmr_ctrl.theory.checks.budget import OF_CORRIDOR, OverBudgetError, budget
from wmr_ctrl.theory.checks.outlook import IN_PART, OF_THEORY, CheckVerdict, verdict
from wmr_ctrl.theory.checks.sample_time import checked_by
from wmr_ctrl.theory.checks.surroundings import lost_samples, rounded_effects
from wmr_ctrl.theory.checks.torques import GRIP
from wmr_ctrl.theory.checks.unknown_zero import bounds, finest, is_undisturbed, unknown_zero
from wmr_ctrl.theory.checks.velocity_guard import void_effects
from wmr_ctrl.theory.corridor import Corridor, find_corridor
from wmr_ctrl.world.grip import grip
from wmr_ctrl.world.phases import robots_in_words
from wmr_ctrl.world.scenario import Scenario, override, unit_questions, unknown_keys
from wmr_ctrl.world.scenario.toml_io import InheritedValue

from . import check_sentences
from .check_stopping import stop_lines, stopping_numbers
from .console import Progress, say, short_number, table, wrapped

MOST_STEPS = 2_000_000
"""Plant steps that one law is run for; twenty times what the paper's runs take."""
UNRUN = ("corridor", "filter", "guard", "inherited", "stability")
"""Subjects of which runs tell nothing."""
NONE, FINDINGS = "-", "findings"
"""Cell of a table that has no value; column of the keys of objections and notes."""


Item = TypeVar("Item")


class Note(NamedTuple):
    """A finding on one law, on all laws (None) or on the scenario (""), with its key or subject."""

    law: str | None
    key: str
    text: str


class Held(NamedTuple):
    """A finding of theory or of a run on a law: key, text, and whether it is an objection."""

    key: str
    text: str
    objects: bool


@dataclass(frozen=True)
class Answers:
    """Everything that theory and one run per law found about a scenario; ``setup`` is any law's.

    ``stable`` is None for a law whose ranges take too much work; ``tubes`` may be left out.
    """

    scenario: Scenario
    setup: Setup
    taken: Sequence[InheritedValue]
    warned: Mapping[str, Sequence[checks.Warning]]
    stable: Mapping[str, checks.Stability | None]
    tubes: Mapping[str, Corridor]
    runs: Mapping[str, Run]

    def verdict(self, law: str) -> CheckVerdict:
        """One-word verdict on a law."""
        return verdict(self.warned[law], self.runs.get(law))

    @cached_property
    def held(self) -> Mapping[str, Sequence[Held]]:
        """Findings on each law, without those that the head of the output already states."""
        said = {Held("assumption-void", self.setup.void, False)}
        said |= {Held(text.partition(" ")[0], text, False) for text in void_effects(self.setup)}
        said |= {Held(*question, True) for question in unit_questions(self.scenario)}
        found = dict[str, Sequence[Held]]()
        for law, warnings in self.warned.items():
            seen = _seen(self, law)
            held = [Held(w.key, w.sentence, w.objects) for w in warnings if w.equation != GRIP]
            held += [Held(item.key, item.text, item.key not in IN_PART) for item in seen]
            found[law] = [item for item in held if item not in said]
        return found

    @cached_property
    def shared(self) -> Sequence[Held]:
        """Findings that several laws share word for word."""
        return _in_each(self.held.values())


def _in_each(lists: Iterable[Sequence[Item]]) -> list[Item]:
    """Items that are in each of several lists."""
    first, *others = lists
    return [item for item in first if others and all(item in other for other in others)]


def find_answers(
    case: Scenario,
    laws: Sequence[str],
    taken: Sequence[InheritedValue],
    only: str | None,
    work: float = inf,
    asked: Sequence[str] = (),
    *,
    corridors: bool = False,
) -> Answers:
    """Compute the answers for these laws; with ``only``, just those that this subject needs.

    ``asked``: the laws that the user named; ``work``: largest work for warnings, and for stable
    ranges, of a law (`wmr_ctrl.theory.checks.budget`); ``corridors``: whether to compute any.
    """
    warned, stable, tubes, bare = {}, {}, {}, only == "corridor"
    with Progress("what theory says") as progress:
        setups = {law: settle(case, law) for law in laws}
        for count, (law, setup) in enumerate(setups.items()):
            progress(count / len(laws))
            if corridors:
                tubes[law] = find_corridor(case, law, whole=True, work=OF_CORRIDOR)
            tyres = (replace(item, objects=False) for item in checks.grip_warnings(setup))
            heard = () if bare else checks.warnings_heard(setup, law in asked, work)
            warned[law] = () if bare else (*heard, *tyres)
            if not bare:
                stable[law] = _stability(case, law, work)
    runs = {} if only in UNRUN else _runs(case, laws)
    return Answers(case, setups[laws[0]], taken, warned, stable, tubes, runs)


def laws_for(scenario: Scenario) -> tuple[str, ...]:
    """Laws that need no further numbers of the robot than the stated ones."""
    return tuple(law for law in LAWS if not lacking(scenario, law))


def _stability(scenario: Scenario, law: str, work: float) -> checks.Stability | None:
    try:
        with budget(work):
            return checks.stability(scenario, law)
    except OverBudgetError:
        return None


def _runs(scenario: Scenario, laws: Sequence[str]) -> dict[str, Run]:
    """One run per law; empty, with a warning on stderr, if no compiler works."""
    runs = {}
    try:
        short = _short(scenario)
        with Progress("one run of each law") as progress:
            for law in laws:
                runs[law] = api.simulate(short, law)
                progress(len(runs) / len(laws))
        return runs
    except CompilerError as error:
        say("warning", f"no law was run: {error}")
        return {}


def _short(scenario: Scenario) -> Scenario:
    """The scenario, shortened to `MOST_STEPS` plant steps if it is longer."""
    clock, window = scenario.clock, scenario.metrics
    if clock.duration <= MOST_STEPS * clock.plant:
        return scenario
    end = int(MOST_STEPS * clock.plant / clock.control) * clock.control
    split = {} if window.split is None else {"metrics.split": min(window.split, end / 2)}
    first = {"metrics.rms_from": min(window.rms_from, end / 2)}
    return override(scenario, {"clock.duration": end, **split, **first})


def document(answers: Answers) -> dict[str, object]:
    """The answers as ``--json`` prints them."""
    case, stable, runs = answers.scenario, answers.stable, answers.runs
    filtering = checks.filter_facts(answers.setup)
    shares = ("guard_share", "filter_share")
    shown = ("position_rms", "tracking", "tracked", "arrival", *shares, "outcome", "remarks")
    figures = {law: summary(run) for law, run in runs.items()}
    warnings = [{"key": w.key, "law": law, "text": str(w)} for law, w in _merged(answers)]
    if zero := unknown_zero(answers.setup):
        warnings.append({"key": zero.key, "law": None, "text": str(zero)})
    inherited = check_sentences.inherited_robot(answers.taken)
    if inherited:
        warnings.append({"key": "inherited", "law": None, "text": inherited})
    return {
        "scenario": case.name,
        "valid": True,
        "grip": _grip(case),
        "warnings": warnings,
        "inherited": {item.key: item.value for item in answers.taken},
        "nominal_duration": {law: run.settings.duration for law, run in runs.items()},
        "nominal": {law: {key: row[key] for key in shown} for law, row in figures.items()},
        "verdict": {law: answers.verdict(law) for law in answers.warned},
        "min_period": {law: limits and limits.shortest for law, limits in stable.items()},
        "max_period": {law: limits and limits.period for law, limits in stable.items()},
        "max_delay": {law: limits and limits.delay for law, limits in stable.items()},
        "mass_range": {law: limits and limits.masses for law, limits in stable.items()},
        "idle": check_sentences.idle_keys(case),
        "arrival": case.reference.arrival,
        "laws": {
            law: {
                "largest_stable_period": (limits := stable.get(law)) and limits.period,
                "warnings": [asdict(warning) for warning in warnings],
            }
            for law, warnings in answers.warned.items()
        },
        "guard": check_sentences.guard_numbers(answers.setup),
        "filter": filtering and asdict(filtering),
        **stopping_numbers(case),
        "bounds": bounds(answers.setup),
        "robots": [{"from": t, "robot": words} for t, words in robots_in_words(case)],
        "corridor": {law: tube.figures for law, tube in answers.tubes.items()} or None,
    }


def _filter_lines(setup: Setup) -> Iterator[str]:
    yield from check_sentences.filter_lines(setup)
    yield from stop_lines(setup)


def _grip(case: Scenario) -> dict[str, float | None]:
    """Torques of the tyres' grip [N m], null if the robot is not known."""
    known = not unknown_keys(case)
    torques = {**asdict(grip(case)), "reference": checks.reference_torque(case)}
    return {name: torque if known else None for name, torque in torques.items()}


def _merged(answers: Answers) -> Iterator[tuple[str | None, checks.Warning]]:
    """Every warning once, with its law, or None if it concerns several laws."""
    shared = _in_each(answers.warned.values())
    yield from ((None, item) for item in shared)
    for law, warnings in answers.warned.items():
        yield from ((law, item) for item in warnings if item not in shared)


def head(answers: Answers, detailed: bool = False) -> Iterator[str]:
    """Questions about units, the promise, and the findings that do not depend on the law.

    With ``detailed``, all `findings` follow, so anything that they repeat is omitted here.
    """
    case = answers.scenario
    yield wrapped(check_sentences.valid(case))
    yield from (wrapped(question) for _, question in unit_questions(case))
    yield from (wrapped(item.sentence) for item in case.changes)
    yield wrapped(check_sentences.promise(answers.setup))
    if not detailed and (zero := unknown_zero(answers.setup)):
        yield wrapped(f"{zero.key}: {zero}")
    if case.reference.arrival is not None:
        yield wrapped(check_sentences.rest(case.reference.arrival, case.clock.duration))
    if answers.taken:
        listed = ", ".join(item.key for item in answers.taken)
        yield wrapped(f"Not stated, so assumed (--only inherited): {listed}.")
    if unknown := unknown_keys(case):
        yield wrapped(f"Not stated, and of no effect on the motion here: {', '.join(unknown)}.")
    if any(run.settings.duration < case.clock.duration for run in answers.runs.values()):
        yield wrapped(f"Each law is run for {MOST_STEPS} plant steps only, not to the end.")
    if not detailed and answers.shared:
        yield "\nWhatever the law:"
        yield from _items(item for item in answers.shared if item.objects)
        yield from _items(item for item in answers.shared if not item.objects)


def _items(held: Iterable[Held]) -> Iterator[str]:
    return (wrapped(f"- {item.key}: {item.text}", indent="  ", hang="  ") for item in held)


def law_table(answers: Answers) -> Iterator[str]:
    """Table of the laws, followed by the meaning of its columns."""
    place = next(map(driving, answers.runs.values()), "drive")
    case = answers.scenario
    period = f"{1e3 * case.clock.control:g}"
    robots = [words for _, words in robots_in_words(case)]
    first = f"; of the robot at the start, {robots[0]}" if robots else ""
    until = f", until {case.changes[0].t:g} s: {robots[0]}" if robots else ""
    exact = "; nothing in the scenario disturbs robot or sensors" * is_undisturbed(case)
    about = {
        "law": "",
        "verdict": "",
        "stable\n[ms]": f"longest stable clock.control, which is {period} here{first}",
        "off\n[mm]": f"RMS distance from the desired position in the {place}, seed 0{exact}",
        "guard\n[%]": "share of samples that the guard changed, on the worse axis",
        "corridor\n[mm]": f"certified largest distance from there, from a start there{until}",
        FINDINGS: "objections by key; in brackets: true, but not a fault of the law",
    }
    columns = zip(*((law, *_cells(answers, law)) for law in answers.warned), strict=True)
    named = dict(zip(about, columns, strict=True))
    shown = {name: cells for name, cells in named.items() if {*cells} != {NONE} or name == FINDINGS}
    yield table(zip(*shown.values(), strict=True), tuple(shown))
    yield ""
    for name in filter(about.get, shown):
        yield wrapped(f"{name.partition(chr(10))[0]}: {about[name]}", hang="  ")
    alone = [item for law in answers.warned for item in _own(answers, law) if item.objects]
    yield from check_sentences.remedies({item.key: item.text for item in reversed(alone)})
    yield wrapped("Reasons and details: --only NAME, with a law or key from the table; or -v.")


def _cells(answers: Answers, law: str) -> Iterator[str]:
    """Table cells of a law; NONE for an absent value."""
    limits, run = answers.stable.get(law), answers.runs.get(law)
    shares = run and guard_share(run)
    drive = (run and tracking(run)["drive"]) or {}
    away, tube = drive.get("position_rms"), answers.tubes.get(law)
    most = None if tube is None else tube.position
    yield answers.verdict(law).removeprefix("holds-").replace("-", " ")
    if limits is None:
        yield "not checked" if law in answers.stable else NONE
    elif limits.period == 0:
        yield "none"
    else:
        low = f"{short_number(1e3 * limits.shortest)} to " if limits.shortest > 0 else ""
        yield low + (short_number(1e3 * limits.period) if limits.period < inf else "any")
    least = 1e3 * finest(answers.scenario)
    yield NONE if away is None else short_number(1e3 * away, least)
    yield short_number(100 * max(shares)) if shares and answers.scenario.guard.enabled else NONE
    yield NONE if most is None else short_number(float(rounded(1e3 * most, 3)), least)  # never less
    yield ", ".join(_reasons(answers, law)) or NONE


def _reasons(answers: Answers, law: str) -> Iterator[str]:
    """Keys of the findings on this law only, in brackets if they are not objections."""
    held = _own(answers, law)
    objected = {item.key for item in held if item.objects}
    for key in dict.fromkeys(item.key for item in held):
        yield key if key in objected else f"({key})"


def _own(answers: Answers, law: str) -> list[Held]:
    """Findings on a law that it does not share with all others."""
    return [item for item in answers.held[law] if item not in answers.shared]


def _seen(answers: Answers, law: str) -> list[Remark]:
    """Remarks on a law's run, except those that repeat the warnings."""
    run = answers.runs.get(law)
    return [item for item in run.remarks if item.key not in OF_THEORY] if run else []


def findings(answers: Answers) -> Iterator[Note]:
    """All findings: first those on the scenario, then those on each law."""
    about = {"guard": check_sentences.guard_lines, "filter": _filter_lines}
    for key, lines in about.items():
        yield from (Note("", key, line) for line in lines(answers.setup))
    if zero := unknown_zero(answers.setup):
        yield Note("", zero.key, f"{zero.key}: {zero}")
    if answers.taken:
        yield Note("", "inherited", check_sentences.inherited_robot(answers.taken))
    ignored = lost_samples(answers.scenario), rounded_effects(answers.scenario)
    heads = ((law, item, "" if item.objects else "note: ") for law, item in _merged(answers))
    warnings = [Note(law, item.key, f"{head}{item}") for law, item, head in heads]
    yield from (item for item in warnings if item.law is None)
    for law in answers.warned:
        if limits := answers.stable.get(law):
            stable = check_sentences.stable(limits, answers.scenario.clock.control)
            left_out = ", and ".join(filter(None, (*limits.remarks, *ignored)))
            yield Note(law, "stability", f"{stable} ({left_out})" if left_out else stable)
        elif law in answers.stable:
            yield Note(law, "stability", f"stable ranges were not checked: {checked_by(law)}")
        yield from (item for item in warnings if item.law == law)
        yield from (Note(law, item.key, f"{item.key}: {item.text}") for item in _seen(answers, law))
        if law in answers.runs:
            run = answers.runs[law]
            rows = (f"{name}: {text}" for name, text in rows_of(run))
            yield Note(law, "run", "; ".join((f"one run, seed 0: {run.outcome.value}", *rows)))
        if law in answers.tubes:
            yield Note(law, "corridor", answers.tubes[law].sentence)


def about(answers: Answers, name: str) -> list[Note]:
    """Findings on a law, a key or a subject; raises ArgumentError if there are none."""
    every = list(findings(answers))
    own = name == "filter"  # whose numbers are asked about, too
    chosen = [n for n in every if name in (n.law, n.key) or (own and n.key.startswith("filter."))]
    if not chosen:
        names = dict.fromkeys((*answers.warned, *(item.key for item in every)))
        raise ArgumentError(f"--only {name!r} is not among the findings: {', '.join(names)}.")
    return chosen


def listed(findings: Iterable[Note]) -> str:
    """Findings as items of a list, below the law that they are about."""
    lines = list[str]()
    for law, notes in groupby(findings, attrgetter("law")):
        lines += [f"\n{law or 'all laws'}"] if law != "" else []
        lines += (wrapped(f"- {item.text}", indent="  ", hang="  ") for item in notes)
    return "\n".join(lines).lstrip("\n")
