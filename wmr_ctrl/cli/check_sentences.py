"""Sentences of ``wmr-ctrl check``: promise, guard, filter, stability, one run."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set

from wmr_ctrl.control.guard.bounds import MASS_KEYS, SourcedNumber, assumption_sources
from wmr_ctrl.control.guard.price import early_speed, speed_price
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.control.laws.law import OwnKinematics
from wmr_ctrl.control.setup import KINEMATICS, Setup, gains_of, settle
from wmr_ctrl.core.data import data
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.section import quantities
from wmr_ctrl.core.fields.units import limits_in_words, rounded, sized
from wmr_ctrl.core.fields.unstated import Unstated
from wmr_ctrl.results import speeds
from wmr_ctrl.theory.checks import Stability, filter_advice, filter_facts
from wmr_ctrl.theory.checks.unknown_zero import exactness
from wmr_ctrl.theory.checks.velocity_base import hears
from wmr_ctrl.theory.checks.velocity_guard import void_effects
from wmr_ctrl.theory.checks.warning import joined
from wmr_ctrl.world.registry import EFFECTS
from wmr_ctrl.world.resistance import against
from wmr_ctrl.world.scenario import Scenario, override, parse_assignments, title_of
from wmr_ctrl.world.scenario.command_filter import FIRST_ORDER, Filter
from wmr_ctrl.world.scenario.sections import Guard
from wmr_ctrl.world.scenario.toml_io import InheritedValue, stated_keys
from wmr_ctrl.world.speed_loops import KINDS, loops_of

from .check_stopping import stop_promise
from .console import wrapped

TOLD = 1e-3
"""Distance from the reference [m] at rest that is worth a word."""
PER_AXIS = {"dbar": ("N", "N m"), "nbar": ("m/s", "rad/s")}

NOT_THE_PATH = "tracking of the path is not"
SHARED_K = "gains.kinematics.k"
REMEDIES: Mapping[str, str] = data(__package__, "remedies.toml")
"""Remedies for objections and remarks, by key."""
SAFE_ANYWAY = ("disturbance.std", "disturbance.truncate", "base.timeout")
"""Keys of which nobody expects more: noise of size 0, its cut, a stop that no loss brings about."""
TUNE = "lower the gains (`wmr-ctrl tune`), or measure better"


def remedies(objections: Mapping[str, str]) -> Iterator[str]:
    """Lines that say what to change, for objections (texts by key): the remedy if there is one,
    else the text.
    """
    for place, (key, text) in enumerate(objections.items()):
        head = "" if place else "\nWhat to change:\n"
        yield head + wrapped(f"{key}: {remedy(key) or text}", indent="  ", hang="  ")


def remedy(key: str) -> str | None:
    """Short remedy of an objection or a remark."""
    like = SHARED_K if key.endswith(".kinematics") else key
    return REMEDIES.get(like, TUNE if key.startswith("gains.") else None)


def rest(arrival: float, duration: float) -> str:
    """State when the desired motion comes to rest [s], and warn if the run ends earlier."""
    late = f"{arrival:.4g} s" if arrival < 3600 else f"{arrival:.0f} s, {arrival / 3600:.3g} h"
    early = f", but the run ends at {duration:g} s: lengthen clock.duration"
    return (
        f"The desired motion comes to rest at its goal at t = {late}"
        f"{early if arrival > duration else ''}."
    )


def valid(case: Scenario) -> str:
    """Sentence that the scenario is valid, with its title."""
    title = title_of(case)
    return f"{case.name} is valid{f' ({title})' if title else ''}."


def promise(setup: Setup) -> str:
    """The promise on the limits, if any: its source and its assumptions."""
    case = setup.scenario
    axes = zip(("v1", "omega"), case.limits.sides, ("m/s", "rad/s"), strict=True)
    limits = " and ".join(
        f"|{name}| <= {high:g} {unit}" if low == -high else f"{low:g} <= {name} <= {high:g} {unit}"
        for name, (low, high), unit in axes
    )
    words = exactness(setup)
    by = "filter" if setup.takes_velocity else "guard"
    assumed = f" The {by} assumes that {words}." if words else ""
    here = f" In this scenario {words}." if words else ""
    while_exact = f"while {words}, and " if words else ""
    if setup.takes_velocity:
        if (rim := case.filter.wheel_speed) is not None:
            limits = f"{limits.replace(' and', ',')} and wheels' speeds <= {rim:g} m/s"
        facts = filter_facts(setup)
        if facts is None:
            return f"No filter: {limits} are not guaranteed.{here} {filter_advice(setup)}"
        if facts.broken:
            return f"Filtered, but nothing is guaranteed: {facts.broken[0]}{assumed}"
        late = max(case.limits.excess(case.initial.velocity)) > 0
        return (
            f"Filtered: {limits} are guaranteed{' for starts within them alone,' * late} "
            f"{while_exact}while the base is within {_whose(case, 'filter')} bounds (--only "
            f"filter); {NOT_THE_PATH}.{stop_promise(case)}"
        )
    if not case.guard.enabled:
        try:
            void = settle(override(case, {"guard.enabled": True}), None).void
        except ScenarioError as error:
            first, _, _ = str(error).partition(". ")
            return f"Not guarded: {limits} are not guaranteed. --guard is refused: {first}.{here}"
        would = f"would not guarantee them either: {void}" if void else "would guarantee them."
        if "guard.dbar" in case.assumed:
            would = "would assume guard.dbar, which nobody stated."
        return f"Not guarded: {limits} are not guaranteed. --guard {would}{here}"
    if setup.void:
        why = (*void_effects(setup), *(item.sentence for item in setup.broken))
        return f"Guarded, but {limits} are not guaranteed: {' '.join(why)}{assumed}"
    # All but what may not be there at all has to stay within the bounds.
    named = {"masses": True, "pushes": any(setup.value("guard.dbar")),
             "errors": any(setup.value("guard.nbar"))}  # fmt: skip
    held = joined(name for name, there in named.items() if there)
    beyond = zip(case.limits.excess(case.initial.velocity), early_speed(setup.guard), strict=True)
    late = any(excess + gained > 0 for excess, gained in beyond)
    return (
        f"Guarded: {limits} are guaranteed{', once the speed is back from its start,' * late} "
        f"{while_exact}while {held} stay within {_whose(case, 'guard')} bounds "
        f"(--only guard); {NOT_THE_PATH}."
    )


def _whose(scenario: Scenario, table: str) -> str:
    """Origin of a table's bounds: "assumed" as soon as one of them is assumed."""
    assumed = any(key.startswith(f"{table}.") for key in scenario.assumed)
    return "assumed" if assumed else {"filter": "its stated", "guard": "the guard's"}[table]


def guard_numbers(setup: Setup) -> dict[str, object] | None:
    """The guard's numbers for JSON, their sources, and the usable speeds; None without a guard."""
    if not setup.scenario.guard.enabled:
        return None
    known = assumption_sources(setup.scenario, setup.guard, setup.effects)
    price = speed_price(setup.scenario, setup.guard)
    return {
        **{name: item.value for name, item in known.items()},
        "sources": {name: dict(item.sources) for name, item in known.items()},
        "usable_speed": price.usable,
        "reference_speed": price.asked,
    }


def guard_lines(setup: Setup) -> Iterator[str]:
    """Two lines on the guard: its assumptions and the usable speeds.  Empty without a guard."""
    if not setup.scenario.guard.enabled:
        return
    known = assumption_sources(setup.scenario, setup.guard, setup.effects)
    parts = [_masses(known) + _differs(setup)]
    for name, (first, second) in PER_AXIS.items():
        a, b = known[name].value
        parts.append(f"{name} {a:.4g} {first}, {b:.4g} {second}{_made(known[name])}")
    parts += [_late(known[name]) for name in ("delay", "lag")]
    ages = [known[name] for name in ("age", "window") if any(known[name].value)]
    parts += [f"{item.name} {_digits(item.value)} s{_made(item)}" for item in ages]
    yield f"the guard assumes {'; '.join(parts)}"
    price = speed_price(setup.scenario, setup.guard)
    yield (
        f"it leaves at most {speeds(price.usable)} against friction; the reference needs at most "
        f"{speeds(price.asked)}"
    )


def filter_lines(setup: Setup) -> Iterator[str]:
    """The command filter in sentences; none without filter."""
    facts = filter_facts(setup)
    if facts is None:
        return
    limits, stated = limits_in_words(setup.scenario.limits.sides), setup.scenario.filter
    (back, v), (right, omega) = (
        [rounded(max(size, 0.0), 3, up=False) for size in (-low, high)]
        for low, high in facts.usable.values()
    )
    ways = f", and backwards {back} m/s, to the right {right} rad/s" * ((back, right) != (v, omega))
    held = "is not guaranteed to keep" if facts.broken else "keeps"
    yield (
        f"the filter ({facts.statement}) {held} {limits}; at rest it leaves at least {v} "
        f"m/s, {omega} rad/s{ways} on any base inside the stated bounds"
        f"{', with odometry in every step' if hears(setup.scenario) else ''}{_slowed(setup)}"
    )
    gain = "gain" if stated.loop == FIRST_ORDER else "peak gain"
    if facts.kind == "band":
        yield (
            "a constant delay costs nothing of that; delays that vary, even by a millisecond, are "
            "refused (filter.delay)"
        )
    costs = {
        "millisecond of delay": None if facts.kind == "band" else facts.delay_cost,
        f"per cent of {gain}": facts.gain_cost,
        "per cent of overshoot": None if facts.rise_cost else facts.overshoot_cost,
    }  # fmt: skip
    if facts.overshoot:
        v, omega = (f"{100 * share:.3g} %" for share in facts.overshoot)
        yield f"steps of such a base overshoot by up to {v} (linear), {omega} (angular)"
    if facts.rise:
        first, second = facts.rise
        more = facts.rise_cost or (0.0, 0.0)
        added = f"; one more per cent of overshoot adds {more[0]:.2g} s, {more[1]:.2g} s"
        yield (
            f"commands reach 0.9 of the limits after {first:.3g} s (linear), {second:.3g} s "
            f"(angular){added if facts.rise_cost else ''}"
        )
    prices = {name: (round(cost[0], 7), round(cost[1], 7)) for name, cost in costs.items() if cost}
    texts = [
        f"one more {name} costs {sized(cost[0], 'm/s', 3)}, {sized(cost[1], 'rad/s', 3)}"
        for name, cost in prices.items()
    ]
    if texts:
        yield "; ".join(texts)


def _slowed(setup: Setup) -> str:
    """Clause on effects that slow a base further and that a clip does not model."""
    case = setup.scenario
    slows = {
        "base.w_max": case.base.w_max < math.inf,
        "base.deadband": any(case.base.deadband),
        "base.wheel_deadband": case.base.wheel_deadband > 0,
        "[resistance]": any(
            loop == "first-order" and slower
            for loop, slower in zip(case.filter.loop, against(case), strict=True)
        ),
    }
    named = [name for name, acts in slows.items() if acts and case.filter.kind == "clip"]
    return f", less what {' and '.join(named)} take" + "s" * (len(named) == 1) if named else ""


def inherited_robot(taken: Sequence[InheritedValue]) -> str:
    """The robot's numbers that were not stated, with where to state them."""
    if not taken:
        return ""
    listed = ", ".join(f"{item.key} = {item.value} {item.unit}".rstrip(" 1") for item in taken)
    return (
        f"Nobody stated {listed}: the file calls these values assumed. State your own; `wmr-ctrl "
        "scenarios paper-simulation --toml` prints all keys with their meaning."
    )


def idle_keys(case: Scenario) -> tuple[str, ...]:
    """Keys that differ from their default but have no effect, as their feature is switched off."""
    off = [effect.section for effect in EFFECTS if not effect.active(case)]
    acting = [*loops_of(case)] if case.takes_velocity else []
    used = {section for loop in acting for section in loop.gains}
    off += [section for loop in KINDS.values() for section in loop.gains if section not in used]
    keys = dict[str, None]()
    for section in (*off, Guard if case.takes_velocity else Filter):
        values = vars(case.section(section))
        named = ((name, what.default) for name, what in quantities(section))
        keys |= {
            f"{section.KEY}.{name}": None
            for name, own in named
            if values[name] != own and not isinstance(values[name], Unstated)
        }
    return tuple(key for key in keys if key not in SAFE_ANYWAY)


def idle_by_user(
    case: Scenario, source: str, assignments: Sequence[str], laws: Sequence[str]
) -> tuple[str, ...]:
    """Keys among `idle_keys` that the user stated, and gains of laws that are not run."""
    given = parse_assignments(assignments)
    stated = stated_keys(source, given)
    gains = [key for key in given if key.startswith("gains.") and key.count(".") > 1]
    others = [key for key in gains if (law := key.split(".")[1]) in LAWS and law not in laws]
    if SHARED_K in given and not any(LAWS[law].traits.auxiliary for law in laws):
        others.append(SHARED_K)
    return (*(key for key in idle_keys(case) if key in stated), *others)


def unread_k(case: Scenario, laws: Sequence[str], stated: Set[str]) -> Iterator[str]:
    """Remarks on laws that read their own k, not the shared one that the user stated."""
    for law in laws if SHARED_K in stated else ():
        own, gains = f"gains.{law}.{KINEMATICS}", gains_of(case, LAWS[law])
        if isinstance(gains, OwnKinematics) and gains.kinematics and own not in stated:
            yield (
                f"{SHARED_K} is stated, and law {law} does not read it: here it has {own} = "
                f"{list(gains.kinematics)}, its own. State that for {law}."
            )


def stable(limits: Stability, period: float) -> str:
    """Sentence on the periods, delays and masses for which a loop is stable."""
    if limits.off is None:
        return f"no rest near the reference within the limits at {period:g} s"
    if limits.period == 0:
        shorter = " and all shorter periods that were tried" if limits.tried < period else ""
        return f"unstable around the reference at {period:g} s{shorter}"
    limit = f"up to clock.control = {limits.period:.4g} s"
    if limits.shortest > 0:
        limit = f"for clock.control = {limits.shortest:.4g} to {limits.period:.4g} s"
    if limits.period >= limits.held:
        limit += ", beyond which the base stops between commands (base.timeout)"
    if limits.period == float("inf"):
        limit = "at every control period that was tried"
    parts = []
    if limits.delay is not None and limits.delay < float("inf"):
        parts.append(limits.delay_words)
    if limits.masses is not None:
        parts.append(limits.mass_words)
    here = f"; at {period:g} s {' and '.join(parts)}" if parts else ""
    place = "around the reference"
    if (off := limits.off) >= TOLD:
        place = f"near its rest, {off:.2g} m off the reference (farther starts may end elsewhere),"
    return f"stable {place} {limit}{here}"


def _masses(known: Mapping[str, SourcedNumber]) -> str:
    low, high = (known[key.removeprefix("guard.")] for key in MASS_KEYS)
    texts = [
        f"{name} {low.value[i]:.4g} to {high.value[i]:.4g} {unit}"
        for i, (name, unit) in enumerate((("M", "kg"), ("I", "kg m2")))
    ]
    origin, other = _made(low), _made(high)
    return f"{', '.join(texts)}{origin if origin == other else f'{origin} to{other}'}"


def _differs(setup: Setup) -> str:
    """State that true mass or inertia differ from the laws' model, within the guard's interval."""
    texts = [
        f"{name} = {setup.value(f'robot.{name}')[0]:.4g} {unit}"
        for name, unit in (("m", "kg"), ("I", "kg m2"))
        if setup.value(f"robot.{name}") != setup.value(f"model.{name}")
    ]
    return f", and the robot has {', '.join(texts)}" if texts else ""


def _late(item: SourcedNumber) -> str:
    low, high = item.value
    if high == 0:
        return f"no {item.name}{_made(item)}"
    text = f"{high:.4g}" if low == high else f"{low:.4g} to {high:.4g}"
    return f"{item.name} {text} s{_made(item)}"


def _digits(values: Iterable[float]) -> str:
    return ", ".join(f"{value:.4g}" for value in values)


def _made(item: SourcedNumber) -> str:
    """Sources of a number, as text in brackets."""
    texts = [
        source if added in (None, item.value) else f"{source} {_digits(added or ())}"
        for source, added in item.sources.items()
    ]
    return f" ({'; '.join(texts)})" if texts else ""
