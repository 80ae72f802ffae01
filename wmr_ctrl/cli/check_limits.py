"""Lines of ``wmr-ctrl check`` on guard and command filter: what they count on and leave."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wmr_ctrl.control.setup import Setup
    from wmr_ctrl.guard.bounds import SourcedNumber

PER_AXIS = {"dbar": ("N", "N m"), "nbar": ("m/s", "rad/s")}


def guard_numbers(setup: Setup) -> dict[str, object] | None:
    """The guard's numbers for JSON, their sources, and the speeds it leaves; None without guard."""
    if not setup.scenario.guard.enabled:
        return None
    from wmr_ctrl.guard.bounds import assumption_sources
    from wmr_ctrl.guard.price import speed_price

    known = assumption_sources(setup.scenario, setup.guard, setup.effects)
    price = speed_price(setup.scenario, setup.guard)
    return {
        **{name: item.value for name, item in known.items()},
        "sources": {name: dict(item.sources) for name, item in known.items()},
        "usable_speed": price.usable,
        "reference_speed": price.asked,
    }


def guard_lines(setup: Setup) -> Iterator[str]:
    """The same in two sentences; none without guard."""
    if not setup.scenario.guard.enabled:
        return
    from wmr_ctrl.guard.bounds import assumption_sources
    from wmr_ctrl.guard.price import speed_price
    from wmr_ctrl.results import speeds

    known = assumption_sources(setup.scenario, setup.guard, setup.effects)
    parts = [_masses(known) + _differs(setup), *(_bound(known[name]) for name in PER_AXIS)]
    parts += [_late(known[name]) for name in ("delay", "lag")]
    ages = [known[name] for name in ("age", "window") if any(known[name].value)]
    parts += [f"{item.name} {_digits(item.value)} s{_made(item)}" for item in ages]
    yield f"the guard counts on {'; '.join(parts)}"
    price = speed_price(setup.scenario, setup.guard)
    yield (
        f"it leaves at most {speeds(price.usable)} against friction; the reference asks for at "
        f"most {speeds(price.asked)}"
    )


def filter_numbers(setup: Setup) -> dict[str, object] | None:
    """Facts of the command filter for JSON; None without one."""
    from wmr_ctrl.checks import filter_facts

    facts = filter_facts(setup)
    return None if facts is None else asdict(facts)


def filter_lines(setup: Setup) -> Iterator[str]:
    """The same in two sentences; none without filter."""
    from wmr_ctrl.checks import filter_facts
    from wmr_ctrl.results import speeds

    facts = filter_facts(setup)
    if facts is None:
        return
    limits = speeds(setup.scenario.limits.v_u1)
    held = "is not promised to keep" if facts.broken else "keeps"
    yield (
        f"the filter ({facts.statement}) {held} {limits}; it leaves {speeds(facts.usable_speed)} "
        "on the weakest base that is stated"
    )
    costs = {"millisecond of delay": facts.delay_cost, "per cent of gain": facts.gain_cost}
    texts = [f"one more {name} costs {speeds(cost)}" for name, cost in costs.items() if cost]
    if texts:
        yield "; ".join(texts)


def _masses(known: Mapping[str, SourcedNumber]) -> str:
    from wmr_ctrl.guard.bounds import MASS_KEYS

    low, high = (known[key.removeprefix("guard.")] for key in MASS_KEYS)
    texts = [
        f"{name} {low.value[i]:.4g} to {high.value[i]:.4g} {unit}"
        for i, (name, unit) in enumerate((("M", "kg"), ("I", "kg m2")))
    ]
    origin, other = _made(low), _made(high)
    return f"{', '.join(texts)}{origin if origin == other else f'{origin} to{other}'}"


def _differs(setup: Setup) -> str:
    """Mass or inertia of the robot where the laws believe another, within what is counted."""
    texts = [
        f"{name} = {setup.value(f'robot.{name}')[0]:.4g} {unit}"
        for name, unit in (("m", "kg"), ("I", "kg m2"))
        if setup.value(f"robot.{name}") != setup.value(f"model.{name}")
    ]
    return f", and the robot has {', '.join(texts)}" if texts else ""


def _bound(item: SourcedNumber) -> str:
    (a, b), (first, second) = item.value, PER_AXIS[item.name]
    return f"{item.name} {a:.4g} {first}, {b:.4g} {second}{_made(item)}"


def _late(item: SourcedNumber) -> str:
    low, high = item.value
    if high == 0:
        return f"no {item.name}{_made(item)}"
    text = f"{high:.4g}" if low == high else f"{low:.4g} to {high:.4g}"
    return f"{item.name} {text} s{_made(item)}"


def _digits(values: Iterable[float]) -> str:
    return ", ".join(f"{value:.4g}" for value in values)


def _made(item: SourcedNumber) -> str:
    """Sources of a number, in brackets."""
    texts = [
        source if added in (None, item.value) else f"{source} {_digits(added or ())}"
        for source, added in item.sources.items()
    ]
    return f" ({'; '.join(texts)})" if texts else ""
