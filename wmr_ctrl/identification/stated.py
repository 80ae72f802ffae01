"""What a user states beside a log, and limits from the log where nobody states any."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.world.scenario import Scenario, inherited, override, scenario_dict
from wmr_ctrl.world.scenario.raw import stated_in
from wmr_ctrl.world.scenario.toml_io import KIND, OF_A_ROBOT, named_keys

from .logs.log import Log
from .logs.samples import Samples, held_speeds

LIMITS, BARRIER, TORQUE = "limits.v_u1", "limits.v_u2", "actuator.tau_max"
BARRIER_FROM = 0.8
"""Share of a limit from which the barrier acts."""
LEAST_SEEN = 1e-3
"""Least speed that counts as motion [m/s, rad/s]."""
MOST_FAR = 2.0
"""Largest ratio of a limit to a speed, or of two commands, over which a log is extrapolated."""
SEEN = "seen in the log, not your limit"
NOT_SHOWN = "the log does not show that it holds up to limits.v_u1"


def believed(
    raw: Log, known: str | Path | Scenario | None, overrides: Mapping[str, object]
) -> tuple[Scenario, set[str]]:
    """The scenario with the known numbers, and the keys that it states, or a preset in it.

    Numbers of a preset that a file extends are assumed.
    """
    given = known if known is not None else raw.base
    scenario = scenario_of(given if given is not None else Scenario(), overrides, guard=False)
    stated = set(overrides)
    for key, value in overrides.items():
        stated |= {f"{key}.{name}" for name in (value if isinstance(value, Mapping) else ())}
    if isinstance(given, Scenario):
        stated |= stated_in(scenario_dict(given))
    elif given is not None:
        stated |= named_keys(str(given))
        silent = {item.key for item in inherited(scenario, str(given), overrides)}
        return replace(scenario, assumed=tuple(sorted(silent))), stated - {*scenario.assumed}
    silent = {*scenario.assumed, *({*OF_A_ROBOT, KIND} - stated)}
    return replace(scenario, assumed=tuple(sorted(silent))), stated - silent


def with_limits(
    scenario: Scenario, sure: set[str], samples: Samples, base: str, remarks: list[str]
) -> tuple[Scenario, dict[str, str]]:
    """The scenario whose limits are those of the log, where nobody stated any.

    Also the keys to write, with words on some.
    """
    high, low, shown = list(scenario.limits.v_u1), list(scenario.limits.v_u2), []
    limits: dict[str, object] = {}
    for axis, (seen, unit) in enumerate(zip(held_speeds(samples), ("m/s", "rad/s"), strict=True)):
        if not {LIMITS, f"{LIMITS}[{axis + 1}]"} & sure and seen > LEAST_SEEN:
            high[axis] = rounded_down(seen)
            follows = float(f"{BARRIER_FROM * high[axis]:.3g}")
            low[axis] = min(low[axis], follows) if BARRIER in sure else follows
            shown.append(f"{LIMITS}[{axis + 1}] = {high[axis]:g} {unit}")
            limits = {LIMITS: high, BARRIER: low}
    torques = np.abs(samples.command).max(axis=0)
    if base == "torque" and TORQUE not in sure and torques.any():
        limits[TORQUE] = rounded_down(float(torques[torques > 0].min()))
        shown.append(f"{TORQUE} = {limits[TORQUE]:g} N m")
    if shown:
        remarks.append(
            f"nobody stated {', '.join(shown)}: this much is seen in the log, and is not your "
            "limit. State yours, as in --set limits.v_u1=0.5,1.2 --set limits.v_u2=0.4,1."
        )
    words = dict.fromkeys(sure, "") | dict.fromkeys({LIMITS, TORQUE} & {*limits}, SEEN)
    assumed = [key for key in limits if key != BARRIER or key not in sure]
    limited = override(scenario, limits)
    return replace(limited, assumed=(*limited.assumed, *assumed)), words


def within_reach(scenario: Scenario, far: Sequence[float], remarks: list[str]) -> bool:
    """False if a limit is more than `MOST_FAR` times the log's largest speed; remarks say so."""
    seen = [limit / share for limit, share in zip(scenario.limits.v_u1, far, strict=True)]
    visited = f"the log shows speeds up to {seen[0]:.2g} m/s and {seen[1]:.2g} rad/s"
    if max(far) > MOST_FAR:
        most = [rounded_down(MOST_FAR * v) for v in seen]
        remarks.append(
            f"the guard is off: {visited}, and nothing is known about those of {LIMITS}. Drive "
            f"faster, or state limits of at most {most[0]:g} m/s and {most[1]:g} rad/s."
        )
        return False
    if max(far) > 1:
        wider = scenario.value("guard.dbar")
        remarks.append(
            f"{visited}. Up to those of {LIMITS} pushes are taken to grow with speed: guard.dbar "
            f"is [{wider[0]:.3g}, {wider[1]:.3g}] in the scenario."
        )
    return True


def written(scenario: Scenario) -> Scenario:
    """The scenario, in which what has its default need not be called assumed: it is left out."""
    base, pi = Scenario(), {"robot.m", "robot.l"} if scenario.base.loop == "pi" else set()

    def differs(key: str) -> bool:
        table, _, name = key.partition(".")
        if key == KIND:
            return scenario.reference_kind.name != base.reference_kind.name
        return vars(scenario.table(table))[name] != vars(base.table(table))[name]

    return replace(scenario, assumed=tuple(k for k in scenario.assumed if k in pi or differs(k)))


def rounded_down(value: float) -> float:
    """A value above 0 with two digits, never more than it is."""
    step = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(f"{math.floor(value / step) * step:.3g}")
