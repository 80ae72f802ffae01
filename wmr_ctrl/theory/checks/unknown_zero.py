"""Bounds of size 0: unknown pushes and errors that are assumed not to exist."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from wmr_ctrl.control.filter.hypotheses import broken_hypotheses
from wmr_ctrl.control.setup import Setup, bound_of, settle
from wmr_ctrl.core.errors import WmrError
from wmr_ctrl.results import Run
from wmr_ctrl.results.consistency import contradictions
from wmr_ctrl.results.verdicts import Warning
from wmr_ctrl.world.effect import EffectRole, Pair
from wmr_ctrl.world.pose_sensor import PoseSensor
from wmr_ctrl.world.registry import EFFECTS
from wmr_ctrl.world.scenario import Scenario

from .outlook import scenario_of_run
from .warning import joined

KEY = "unknown-zero"
PUSHES = (
    "nothing pushes the robot",
    "nothing pushes the robot forwards or backwards",
    "nothing pushes the robot into a turn",
)
"""Words for a bound of both axes, of the linear and of the angular one."""
ERRORS = (
    "its speed is measured exactly",
    "its forward speed is measured exactly",
    "its turning speed is measured exactly",
)
COMMANDS = ("its commands act exactly", "its commands of v act exactly",
            "its commands of omega act exactly")  # fmt: skip
STANDS = "nothing that is in the way comes nearer"
SCALE = "a spring scale shows the largest pull of people, cables and slopes"
STEADY = "the largest difference from the true speed, over a measured length and counted turns"
REMEDIES = {
    "guard.dbar": f"guard.dbar = [N, N m] ({SCALE}; times its lever that is the moment)",
    "guard.nbar": f"guard.nbar = [m/s, rad/s], or [encoder] and [gyro] ({STEADY})",
    "filter.d": "filter.d = [m/s, rad/s] (the largest change of speed, at a constant command, over "
    "the steepest slope and the roughest floor)",
    "filter.push": f"filter.push = [N, N m] ({SCALE}; times its lever that is the moment)",
    "filter.nearing": "filter.nearing = m/s (the fastest of what may come towards the robot)",
    "filter.odometry": f"filter.odometry = [m/s, rad/s] ({STEADY})",
}
"""How to state each bound."""
COMMAND_ERROR = "filter.d = [m/s, rad/s] (half of the step in which the base rounds commands)"
"""Remedy for the d of PI loops, which is no push."""
COARSE, FINE = 1e-4, 1e-6
"""Errors [m, rad] below which no digit is printed: of a run that nothing disturbs, and of others.

A tenth of a millimetre is what no floor and no tape measure knows of a robot.
"""


@dataclass(frozen=True)
class ZeroBound:
    """A bound that is 0: its key, and the statement about the robot that it implies."""

    key: str
    words: str
    remedy: str = ""


def bounds(setup: Setup) -> dict[str, Pair | None]:
    """Bounds that guard or filter assume, by name; None for odometry that no filter uses.

    For a base that takes torques, "dbar" [N, N m] and "nbar" [m/s, rad/s], as stated or implied;
    for one that takes velocities, "d" and "odometry" [m/s, rad/s], as stated.
    """
    if setup.takes_velocity:
        stated = setup.scenario.filter
        return {"d": stated.d, "odometry": stated.odometry}
    return {"dbar": setup.guard.dbar, "nbar": setup.guard.nbar}


def is_guarded(setup: Setup) -> bool:
    """True with a guard, or a filter of a base that takes velocities, switched on."""
    case = setup.scenario
    return case.filter.kind != "none" if setup.takes_velocity else case.guard.enabled


def zeros(setup: Setup) -> tuple[ZeroBound, ...]:
    """Bounds that are 0 on an axis: those of the guard or filter, or of the scenario without them.

    Effects that state no bound are not reported.
    """
    return tuple(_of_filter(setup) if setup.takes_velocity and is_guarded(setup) else
                 _of_guard(setup) if is_guarded(setup) else _of_scenario(setup))  # fmt: skip


def _of_guard(setup: Setup) -> Iterator[ZeroBound]:
    for key, words in (("guard.dbar", PUSHES), ("guard.nbar", ERRORS)):
        yield from _zero(key, setup.value(key), words)


def _of_filter(setup: Setup) -> Iterator[ZeroBound]:
    stated = setup.scenario.filter
    for key, words, remedy, of_pi in (
        ("filter.push", PUSHES, "", True),
        ("filter.d", COMMANDS, COMMAND_ERROR, True),
        ("filter.d", PUSHES, "", False),
    ):
        sizes = zip(setup.value(key), stated.loop, strict=True)
        own = tuple(size if (loop == "pi") == of_pi else math.inf for size, loop in sizes)
        yield from _zero(key, own, words, remedy)
    if stated.kind == "governor" and stated.odometry is not None:
        yield from _zero("filter.odometry", stated.odometry, ERRORS)
    if stated.free_error is not None:
        yield from _zero("filter.nearing", (stated.nearing,), (STANDS,) * 3)


def _of_scenario(setup: Setup) -> Iterator[ZeroBound]:
    unknown = {item.role for item in setup.effects if item.bound is None}
    if unknown <= {EffectRole.SENSOR}:
        yield from _zero("", setup.bound.dbar, PUSHES)
    if EffectRole.SENSOR not in unknown:
        yield from _zero("", setup.bound.nbar, ERRORS)


def _zero(
    key: str, bound: tuple[float, ...], words: tuple[str, str, str], remedy: str = ""
) -> Iterator[ZeroBound]:
    none = [size == 0 for size in bound]
    if any(none):
        which = 0 if all(none) else 1 + none.index(True)
        yield ZeroBound(key, words[which], remedy or REMEDIES.get(key, ""))


def exactness(setup: Setup) -> str:
    """Meaning of bounds of size 0, as "nothing pushes the robot and its speed ..."; or empty."""
    found = zeros(setup)
    return joined(item.words for item in found) if found else ""


def unknown_zero(setup: Setup) -> Warning | None:
    """The warning on bounds of size 0 of a guard or filter that is on, stated or not."""
    found = zeros(setup)
    if not found or not is_guarded(setup):
        return None
    by = "filter" if setup.takes_velocity else "guard"
    values = {item.key: ", ".join(f"{v:g}" for v in setup.value(item.key)) for item in found}
    named = joined(f"{key} = [{digits}]" for key, digits in values.items())
    return Warning(
        KEY,
        f"With {named} the {by} assumes that {exactness(setup)}, which is true of no robot. "
        f"Measure and state {'; and '.join(item.remedy for item in found)}.",
        "docs/filter.md" if setup.takes_velocity else "guard, docs/guarantee.md",
        objects=False,
    )


def is_undisturbed(scenario: Scenario) -> bool:
    """True if no push and no error acts in a scenario's runs, according to the effects' bounds."""
    present = tuple(item for item in EFFECTS if item.present(scenario))
    bound = bound_of(scenario, present)
    known = all(item.bound is not None for item in present)
    exact = not any((*bound.dbar, *bound.nbar, *bound.command))
    return known and exact and scenario.section(PoseSensor).perfect


def finest(scenario: Scenario | None) -> float:
    """Resolution [m, rad] of printed errors; ``scenario`` is None if it is unknown."""
    return COARSE if scenario is not None and is_undisturbed(scenario) else FINE


def promise_of_run(run: Run) -> str:
    """Sentence on what guard, filter or scenario assume to be exact in a run; or empty."""
    scenario = scenario_of_run(run)
    if scenario is None:
        return ""
    try:
        setup = settle(scenario, run.law)
    except WmrError:
        return ""
    words = exactness(setup)
    if not words:
        return ""
    if not is_guarded(setup):
        return f"In this scenario {words}."
    late = setup.takes_velocity and run.provenance.get("master") == "jacobi"
    void = setup.void or late or contradictions(run)
    broken = void or broken_hypotheses(scenario, setup.bound)
    by = "filter" if setup.takes_velocity else "guard"
    return f"{f'The {by} assumes that' if broken else 'The limits are guaranteed while'} {words}."
