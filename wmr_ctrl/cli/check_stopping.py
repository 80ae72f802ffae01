"""Sentences of ``wmr-ctrl check`` on limits that change and on stops before obstacles."""

import math
from collections.abc import Iterator
from dataclasses import asdict

from wmr_ctrl.control.filter.governor_step import schedules
from wmr_ctrl.control.filter.stop_numbers import (
    Stopping,
    costs,
    fastest,
    leaves_from,
    leaving,
    pull_away,
    rolls_back,
    smallest_window,
    stopping,
    times_inside,
)
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.core.fields.units import length
from wmr_ctrl.world.scenario import Scenario

SPEEDS = (0.1, 0.25, 0.5, 0.75, 1.0)
"""Speeds, as shares of the limit, for which `check` prints stopping distances."""
BACK = (", backwards,", ", to the right,")
"""The other direction of v and of omega."""


def stopping_table(case: Scenario) -> list[Stopping] | None:
    """Distances of stops from several speeds; None for a filter that receives no distance."""
    if not case.takes_velocity or not case.filter.is_told or case.filter.free_error is None:
        return None
    return [stopping(case, share * fastest(case)) for share in SPEEDS]


def stopping_numbers(case: Scenario) -> dict[str, object]:
    """`stopping_table` and the cost of more uncertainty, for JSON; null if no distance is
    received.
    """
    table = stopping_table(case)
    return {
        "stopping": table and [asdict(row) for row in table],
        "stopping_costs": costs(case) if table else None,
    }


def stop_promise(case: Scenario) -> str:
    """A filter's promise about stops; empty if there is none."""
    if not (table := stopping_table(case)):
        return ""
    return (
        f" It stops before obstacles, from {table[-1].speed:g} m/s within "
        f"{length(table[-1].distance)}."
    )


def stop_lines(setup: Setup) -> Iterator[str]:
    """Stops, how the base leaves, and times of lowered limits; none without such inputs."""
    case = setup.scenario
    if table := stopping_table(case):
        yield from _distances(case, table)
    if case.takes_velocity and case.filter.changing:
        yield from _times(case)


def _distances(case: Scenario, table: list[Stopping]) -> Iterator[str]:
    rows = (f"{row.speed:g} m/s {length(row.distance)}" for row in table)
    last = table[-1]
    yield (
        f"it stops within: {', '.join(rows)}; of the last, delay takes {length(last.delay)}, "
        f"pushes {length(last.push)}, the brake {length(last.brake)}, the distance's error "
        f"{length(last.error)}"
    )
    slow = "decel" if case.filter.kind == "clip" else "tau"
    names = {"millisecond": "millisecond of delay", "per_cent": f"per cent of {slow}",
             "rest_second": "second of rest"}  # fmt: skip
    prices = (f"{names[key]} {length(price)}" for key, price in costs(case).items())
    yield f"one more costs: {', '.join(prices)}"
    if rolled := rolls_back(case):
        yield (
            f"a push may roll it back by {length(rolled)} during a stop: add that to the body's "
            "radius where distances in the plane are computed"
        )
    turned, held = smallest_window(case)
    if turned > 0:
        yield (
            f"a push turns it by up to {turned:.3g} rad during a stop: state at least as much free "
            f"turning (`look` of the ROS 2 node), and {held:.3g} rad for it to turn away"
        )
    yield from _leaving(case)


def _leaving(case: Scenario) -> Iterator[str]:
    settings, words = case.filter, {-1: "an obstacle ahead", 1: "an obstacle behind"}
    if settings.d[0] and schedules(case)[0].stops_alone:
        yield (
            "commands can never move it away from an obstacle: it may stop by itself between two "
            f"of them (filter.hold = {settings.hold:g} s), so that it is never known to be at rest"
        )
        return
    able = [place for way, place in words.items() if pull_away(case, way) > 0]
    for place in words.values():
        if place not in able:
            yield (
                f"commands are not sure to move it away from {place}: the limit away from it is "
                f"too small for filter.d = {settings.d[0]:g} m/s and filter.gain"
            )
    if settings.nearing or (settings.kind == "clip" and settings.d[0]):
        why = "filter.nearing uses up" if settings.nearing else "a clip does not count"
        for place in ["an obstacle"] if len(able) == 2 else able:
            yield (
                f"it moves away only from {place} told to be {length(leaves_from(case))} away or "
                f"more, which one release may cost: {why} what a held command gains"
            )
    elif settings.d[0]:
        found = {place: own for way, place in words.items() if (own := leaving(case, way))}
        if len(found) == 2 and len({*found.values()}) == 1:
            found = {"an obstacle": found[words[-1]]}
        for place, own in found.items():
            yield (
                f"to move away from {place}, hold a command of at least {own.least:.3g} m/s "
                f"(the largest for {own.hold:.2g} s); it is known to stand {own.rest:.3g} s after "
                f"it was told to stop, and if a command ends too early it rolls up to "
                f"{length(own.roll)}"
            )


def _times(case: Scenario) -> Iterator[str]:
    if case.filter.kind == "clip":
        yield (
            "a limit that is lowered is kept in the end; no time is promised, since a clip does "
            "not know the base's speed: a governor does"
        )
        return
    for axis, unit in enumerate(("m/s", "rad/s")):
        ends = (case.limits.v_max[axis], ""), (-case.limits.v_min[axis], BACK[axis])
        for limit, way in dict(reversed(ends)).items():
            rows = dict[float, list[str]]()
            for before, after, time in times_inside(case, axis, limit):
                shown = f"{time:.3g}" if time < math.inf else "no time promised (filter.d)"
                rows.setdefault(before, []).append(f"{after:.3g}: {shown}")
            yield (
                f"seconds after which a limit lowered from one [{unit}] to another{way} is kept, "
                "counted from the step that lowers it:"
            )
            yield from (f"from {at:.3g} to {', '.join(texts)}" for at, texts in rows.items())
