"""A user's first scenario: content of robot files, cautious values for the rest, and a path.

The shares below are our choice.  For all limits they give a guard or filter that can be met and a
circle with reserve.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

import tomlkit

from wmr_ctrl.core.data import data
from wmr_ctrl.core.errors import ScenarioError, printable
from wmr_ctrl.core.fields.section import default, quantities
from wmr_ctrl.world.references import REFERENCES
from wmr_ctrl.world.references.kind import driven
from wmr_ctrl.world.robot_files import NAMES, Found, Sheet
from wmr_ctrl.world.robot_files.found import LEAST, LIMITS, TOP

from .scenario import sections
from .sections import Robot
from .toml_io import loads_scenario

LAW = "kanayama"
Value: TypeAlias = float | bool | str | tuple[float, ...]
OPTIONAL = (
    *("body.radius", "robot.m", "robot.I", "robot.r", "robot.l"),
    *("base.timeout", "base.accel", "base.decel"),
)
RAMPS = OPTIONAL[-2:]
"""Keys that a base that takes velocities does without, unless a file states them."""
HOW: Mapping[str, str] = data(__package__, "new.toml")
"""How to find each value that no file states."""
OURS = ("law", "base.kind", "filter.kind", "guard.enabled", "guard.alpha", "reference")
"""Choices and what follows from them: nothing that could be measured."""
ROOM = {"velocity": 0.05, "torque": 0.2}
"""Share of the limit ahead that pushes need behind, by the base."""
TABLES = (
    *("", "robot", "body", "base", "actuator"),
    *("limits", "filter", "guard", "clock", "reference"),
)
"""Tables in the order in which they are written."""


@dataclass(frozen=True)
class NewScenario:
    """Text of a scenario, and which of its values were found, assumed (our choices) or unknown.

    ``unused``: values in files for keys that this base lacks, or that other files overruled.
    ``nodes``: parameters and topics for the ROS 2 nodes.
    """

    text: str
    found: Mapping[str, Found]
    assumed: Mapping[str, Value]
    unknown: Mapping[str, Value]
    unused: tuple[Found, ...]
    nodes: Mapping[str, Found]


def new_scenario(sheet: Sheet, base: str, title: str) -> NewScenario:
    """The scenario of a base that takes "velocity" or "torque" commands.

    Raises ScenarioError if a value of a file is impossible.
    """
    sheet = _with_room(sheet, ROOM[base])
    values = _values(sheet, base)
    nodes = {key: item for key, item in sheet.found.items() if key.startswith(NAMES)}
    found = {key: item for key, item in sheet.found.items() if key.partition("[")[0] in values}
    rest = {key: value for key, value in values.items() if key not in found}
    assumed = {key: value for key, value in rest.items() if key.startswith(OURS)}
    unknown = {key: value for key, value in rest.items() if key not in assumed}
    unused = [item for key, item in sheet.found.items() if key not in {**found, **nodes}]
    text = "\n".join(_lines(values, found, [*unknown], title))
    try:
        loads_scenario(text, title)
    except ScenarioError as error:
        sources = "; ".join(item.source for key, item in found.items() if key in str(error))
        raise ScenarioError(f"{error} (From {sources or 'the files'}.)") from None
    return NewScenario(text, found, assumed, unknown, (*unused, *sheet.overruled), nodes)


def _with_room(sheet: Sheet, share: float) -> Sheet:
    """The sheet with backward limits that leave room for the speed that a push may cause."""
    found = dict(sheet.found)
    for key in [key for key in found if key.startswith(LEAST)]:
        top, least = found[key.replace(LEAST, TOP)], found[key]
        ends = [v if isinstance(v, tuple) else (v,) for v in (top.value, least.value)]
        assert all(isinstance(end, tuple) for end in ends)
        wide = tuple(min(low, -_short(share * high)) for high, low in zip(*ends, strict=True))
        if wide != ends[1]:
            words = f"{least.source}: {least.text}, and as much as pushes may do"
            value = wide if isinstance(least.value, tuple) else wide[0]
            found[key] = replace(least, value=value, source=words)
    return replace(sheet, found=found)


def _values(sheet: Sheet, base: str) -> dict[str, Value]:
    """Every key of the file with its value, in the order of the file."""
    stated = {key: item.value for key, item in sheet.found.items()}
    sizes = {key: value for key, value in stated.items() if isinstance(value, float)}
    apart = any(key.startswith(LEAST) for key in stated)
    top = TOP if apart else LIMITS
    v, omega = _pair(stated, top, (0.3, 0.6))
    for key in RAMPS:
        ends = tuple(sizes.get(f"{key}[{axis}]", math.inf) for axis in (1, 2))
        if min(ends) < math.inf:
            stated[key] = ends
    ramps = [stated[key] for key in RAMPS if base == "velocity" and key in stated]
    reached = [min(ends) for ends in zip((math.inf, math.inf), *ramps, strict=True)]
    speed, rate = (_short(min(ends)) for ends in zip(driven((v, omega)), reached, strict=True))
    period = sizes.get("clock.control", 0.05 if base == "velocity" else 0.01)
    guess: dict[str, Value] = {"law": LAW, top: (v, omega), "clock.control": period}
    if apart:
        guess[LEAST] = _pair(stated, LEAST, (-v, -omega))
    if base == "velocity":
        guess |= {"base.kind": base, "base.tau": (0.2, 0.2), "base.delay": 0.05}
        guess |= {"filter.kind": "clip", "filter.gain": (0.9, 1.1)}
        guess |= {"filter.d": (_short(0.05 * v), _short(0.05 * omega))}
    else:
        guess |= _guarded(sizes, v, omega, period)
    guess |= {"reference.kind": "circle", "reference.radius": _short(speed / rate)}
    guess["reference.rate"] = rate
    optional = OPTIONAL if base == "velocity" else OPTIONAL[:1]
    values = guess | {key: stated[key] for key in stated if key in guess or key in optional}
    return dict(sorted(values.items(), key=lambda item: TABLES.index(item[0].rpartition(".")[0])))


def _pair(stated: Mapping[str, Value], key: str, guess: tuple[float, float]) -> tuple[float, float]:
    """Values of a key on both axes; ``guess`` for an axis without a value in the files."""
    sizes = {name: value for name, value in stated.items() if isinstance(value, float)}
    pair = stated.get(key, tuple(sizes.get(f"{key}[{i}]", guess[i - 1]) for i in (1, 2)))
    assert isinstance(pair, tuple)
    return pair[0], pair[1]


def _guarded(sizes: Mapping[str, float], v: float, omega: float, period: float) -> dict[str, Value]:
    """A robot, drives whose thrust is half of its weight, and a guard that assumes less.

    Unknown mass, half track or inertia follow from I = m l^2.
    """
    m, l, inertia = (sizes.get(f"robot.{name}") for name in ("m", "l", "I"))
    if m is None:
        m = 10.0 if inertia is None or l is None else inertia / l**2
    if l is None:
        l = 0.2 if inertia is None else math.sqrt(inertia / m)
    if inertia is None:
        inertia = m * l * l
    r, g = sizes.get("robot.r", 0.08), default(Robot).g
    thrust = 0.5 * m * g
    errors, axes = (0.02 * v, 0.02 * omega), ((m, 1.0, v), (inertia, l, omega))
    swing = max(mass * error / arm for (mass, arm, _), error in zip(axes, errors, strict=True))
    alpha = 0.3 * min(1 / period, thrust / swing)
    push = [min(0.06 * thrust * arm, 0.07 * mass * alpha * limit) for mass, arm, limit in axes]
    return {
        "robot.m": _short(m),
        "robot.I": _short(inertia),
        "robot.mu": min(0.02, _short(0.1 * alpha * v / g)),
        "robot.r": r,
        "robot.l": _short(l),
        "actuator.tau_max": _short(thrust * r / 2),
        "guard.enabled": True,
        "guard.mass_margin": 0.2,
        "guard.dbar": (_short(push[0]), _short(push[1])),
        "guard.nbar": (_short(errors[0]), _short(errors[1])),
        "guard.alpha": _short(alpha),
    }


def _short(value: float) -> float:
    return float(f"{value:.3g}")


def _lines(
    values: Mapping[str, Value],
    found: Mapping[str, Found],
    unknown: list[str],
    title: str,
) -> Iterator[str]:
    """Lines of the file: unit and meaning above each key, its source beside it."""
    yield f"title = {_toml(title)}"
    yield "# Nobody stated these: `wmr-ctrl check` lists them. Take one away when you state it."
    yield f"assumed = {_toml(unknown)}"
    table = ""
    for key, value in values.items():
        part, _, name = key.rpartition(".")
        if part != table:
            yield f"\n[{part}]"
        table = part
        unit, meaning = _meaning(part, name)
        yield f"# {f'[{unit}] ' * (unit not in ('', '1'))}{meaning}"
        sources = [found[name].source for name in (key, f"{key}[1]", f"{key}[2]") if name in found]
        if key not in found:
            sources.append(f"{'UNKNOWN' if key in unknown else 'ours'}: {HOW[key]}")
        beside = printable("; ".join(sources))
        shown = list(value) if isinstance(value, tuple) else value
        yield f"{name} = {_toml(shown)}  # {beside}"


def _toml(value: object) -> str:
    return tomlkit.item(value).as_string()


def _meaning(table: str, name: str) -> tuple[str, str]:
    """Unit and meaning of a key."""
    if not table:
        return "", "control law"
    if name == "kind" and table == "reference":
        return "", "kind of the desired motion"
    known = {**sections(), "reference": REFERENCES["circle"].section}[table]
    what = dict(quantities(known))[name]
    return what.unit, what.doc
