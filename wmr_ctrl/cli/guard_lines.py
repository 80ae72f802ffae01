"""What ``wmr-ctrl check`` says of the guard: the numbers it counts on, and what it leaves."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wmr_ctrl.control.setup import Setup
    from wmr_ctrl.guard.bounds import SourcedNumber

PER_AXIS = {"dbar": ("N", "N m"), "nbar": ("m/s", "rad/s")}


def guard_numbers(setup: Setup) -> dict[str, object] | None:
    """The guard's numbers for JSON, what each is made of, and what it leaves; None without one."""
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
    parts += [_aged(known[name]) for name in ("age", "window") if any(known[name].value)]
    yield f"the guard counts on {'; '.join(parts)}"
    price = speed_price(setup.scenario, setup.guard)
    yield (
        f"it leaves at most {speeds(price.usable)} against friction; the reference asks for at "
        f"most {speeds(price.asked)}"
    )


def _masses(known: Mapping[str, SourcedNumber]) -> str:
    low, high = known["M_min"], known["M_max"]
    texts = [
        f"{name} {low.value[i]:.4g} to {high.value[i]:.4g} {unit}"
        for i, (name, unit) in enumerate((("M", "kg"), ("I", "kg m2")))
    ]
    origin = _made(low)
    other = _made(high)
    return f"{', '.join(texts)}{origin if origin == other else f'{origin} to{other}'}"


def _differs(setup: Setup) -> str:
    """Where the robot has another mass or inertia than the laws believe, within what is counted."""
    pairs = (("m", "kg"), ("I", "kg m2"))
    texts = [
        f"{name} = {setup.value(f'robot.{name}')[0]:.4g} {unit}"
        for name, unit in pairs
        if setup.value(f"robot.{name}") != setup.value(f"model.{name}")
    ]
    return f", and the robot has {', '.join(texts)}" if texts else ""


def _bound(item: SourcedNumber) -> str:
    pairs = zip(item.value, PER_AXIS[item.name], strict=True)
    return f"{item.name} {', '.join(f'{value:.4g} {unit}' for value, unit in pairs)}{_made(item)}"


def _late(item: SourcedNumber) -> str:
    low, high = item.value
    if high == 0:
        return f"no {item.name}{_made(item)}"
    text = f"{high:.4g}" if low == high else f"{low:.4g} to {high:.4g}"
    return f"{item.name} {text} s{_made(item)}"


def _aged(item: SourcedNumber) -> str:
    """Of the measured velocities, per axis."""
    return f"{item.name} {', '.join(f'{value:.4g}' for value in item.value)} s{_made(item)}"


def _digits(value: float) -> str:
    return f"{value:.4g}"


def _made(item: SourcedNumber) -> str:
    """What a number is made of, in brackets."""
    texts = [
        source
        if added in (None, item.value)
        else f"{source} {', '.join(map(_digits, added or ()))}"
        for source, added in item.sources.items()
    ]
    return f" ({'; '.join(texts)})" if texts else ""
