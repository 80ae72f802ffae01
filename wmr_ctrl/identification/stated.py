"""Values that a user states beside a log, and limits from the log if nobody states them."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.data import data
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.section import default
from wmr_ctrl.core.fields.units import rounded
from wmr_ctrl.core.fields.unstated import Unknown
from wmr_ctrl.world.scenario import MissingKeysError, Scenario, from_dict, override, scenario_dict
from wmr_ctrl.world.scenario.raw import apply, merge, stated_in
from wmr_ctrl.world.scenario.sections import BARRIER_FROM, Robot
from wmr_ctrl.world.scenario.toml_io import raw_of
from wmr_ctrl.world.scenario.unstated import KIND

from .bounds import UNDETERMINED, Estimates, Origin
from .logs.log import UNITS, Log, Names
from .logs.samples import Samples, held_speeds
from .written import values_in

LIMITS, BARRIER, TORQUE = "limits.v_u1", "limits.v_u2", "actuator.tau_max"
STAND_IN: Mapping[str, object] = data(__package__, "stand_in.toml")
"""Numbers for reading a log before it is identified; unstated ones are not written."""
LEAST_SEEN = 0.01
"""Least speed that counts as motion [m/s, rad/s]: what sensors show at rest is less."""
MOST_FAR = 2.0
"""Largest ratio of a limit to a speed, or of two commands, over which a log is extrapolated."""
DROPPED = ("gust", "wheels", "slope", "motor", "push", "changes")
"""Tables that no file which extends another one can take back."""
SEEN = "seen in the log, not your limit"
NOT_SHOWN = "the log does not show that it holds up to limits.v_u1"


def believed(
    raw: Log, known: str | Path | Scenario | None, overrides: Mapping[str, object]
) -> tuple[Scenario, set[str], Origin]:
    """The scenario with the known numbers, the keys that it states, and its base scenario.

    Values of `STAND_IN` are assumed if nobody states them.
    """
    given, origin = known if known is not None else raw.base, Origin()
    stated = {*overrides, *stated_in(overrides)}
    if isinstance(given, Scenario):
        scenario = scenario_of(given, overrides, guard=False)
        stated |= stated_in(scenario_dict(given))
        silent = {*scenario.assumed}
    else:
        source = {} if given is None else raw_of(str(given))
        whole = apply(merge(STAND_IN, source), overrides)
        scenario = scenario_of(from_dict(whole, "identified"), {}, guard=False)
        if given is not None and not {*source} & {*DROPPED}:
            own = scenario_dict(from_dict(merge(STAND_IN, source), "identified"))
            origin = Origin(str(given), values_in(own, source))
        stated |= stated_in(source)
        silent = {*scenario.assumed, *(stated_in(STAND_IN) - stated)}
    return replace(scenario, assumed=tuple(sorted(silent))), stated - silent, origin


def with_limits(
    scenario: Scenario, sure: set[str], samples: Samples, base: str, remarks: list[str]
) -> tuple[Scenario, dict[str, str]]:
    """The scenario, with limits from the log if nobody stated any, and the keys to write.

    Some keys come with a comment.
    """
    high, low, shown = list(scenario.limits.v_u1), list(scenario.limits.v_u2), []
    limits: dict[str, object] = {}
    for axis, (seen, unit) in enumerate(zip(held_speeds(samples), UNITS, strict=True)):
        if not {LIMITS, f"{LIMITS}[{axis + 1}]"} & sure and seen > LEAST_SEEN:
            high[axis] = rounded_down(seen)
            low[axis] = min(low[axis], float(f"{BARRIER_FROM * high[axis]:.3g}"))
            shown.append(f"{LIMITS}[{axis + 1}] = {high[axis]:g} {unit}")
            limits = {LIMITS: high, **({BARRIER: low} if BARRIER in sure else {})}
    torques = np.abs(samples.command).max(axis=0)
    if base == "torque" and TORQUE not in sure and torques.any():
        limits[TORQUE] = rounded_down(float(torques[torques > 0].min()))
        shown.append(f"{TORQUE} = {limits[TORQUE]:g} N m")
    if shown:
        remarks.append(
            f"nobody stated {', '.join(shown)}: this much is seen in the log, and is not your "
            "limit. State yours, as in --set limits.v_u1=0.5,1.2."
        )
    words = dict.fromkeys(sure, "") | dict.fromkeys({LIMITS, TORQUE} & {*limits}, SEEN)
    assumed = [key for key in limits if key != BARRIER]
    limited = override(scenario, limits)
    return replace(limited, assumed=(*limited.assumed, *assumed)), words


def beyond(scenario: Scenario, log: Samples) -> list[float]:
    """Each limit divided by the largest speed of the log, at least 1."""
    pairs = zip(scenario.limits.v_u1, held_speeds(log), strict=True)
    return [max(limit / max(seen, LEAST_SEEN), 1.0) for limit, seen in pairs]


def too_far(scenario: Scenario, far: Sequence[float]) -> str:
    """Reason why bounds from a log cannot be valid up to the limits, which are `beyond` it; "" if
    none.
    """
    for limit, share, unit in zip(scenario.limits.v_u1, far, UNITS, strict=True):
        if share > MOST_FAR:
            seen = limit / share
            return (
                f"the limit {limit:.3g} {unit} is more than twice the largest speed that the log "
                f"shows, {seen:.3g} {unit}. Drive faster, or state a limit of at most "
                f"{rounded_down(MOST_FAR * seen):g} {unit}."
            )
    return ""


def refusal(scenario: Scenario, check: Callable[[Scenario], object]) -> str:
    """Reason why ``check`` or the scenario's other numbers refuse it; "" if they do not."""
    try:
        settle(scenario, None)
        check(scenario)
    except ScenarioError as error:
        return f"with these numbers it is refused. {error}"
    return ""


def written(scenario: Scenario) -> Scenario:
    """The scenario without unstated values that nothing depends on.

    A value equal to its default need not be listed as assumed, so it is omitted.
    """
    robot = {key.partition(".")[2] for key in scenario.assumed if key.startswith("robot.")}
    placeholders = {k: v for k, v in vars(default(Robot)).items() if k in robot}
    with suppress(MissingKeysError):
        scenario = replace(scenario, robot=replace(scenario.robot, **placeholders))

    def differs(key: str) -> bool:
        table, _, name = key.partition(".")
        if key == KIND:
            return True
        value = vars(scenario.table(table))[name]
        usual = vars(default(type(scenario.table(table))))[name]
        return not isinstance(value, Unknown) and value != usual

    return replace(scenario, assumed=tuple(filter(differs, scenario.assumed)))


def undetermined(parameters: Estimates) -> list[str]:
    """Keys of the robot's mass and inertia that were fitted but are not determined."""
    fitted = {"robot.m": parameters.get("m"), "robot.I": parameters.get("I")}
    return [key for key, item in fitted.items() if item and item.verdict == UNDETERMINED]


def not_found(sure: set[str], samples: Samples, parameters: Estimates) -> Names:
    """Keys that a scenario must state, but that neither the log nor a user gives."""
    still = [f"{LIMITS}[{axis}]" for axis in (1, 2) if held_speeds(samples)[axis - 1] <= LEAST_SEEN]
    missing = [key for key in undetermined(parameters) if key not in sure]
    if LIMITS not in sure and not sure.issuperset(still):
        missing.append(LIMITS)
    return tuple(missing)


def rounded_down(value: float) -> float:
    """A positive value rounded down to two digits."""
    return float(rounded(value, 2, up=False))
