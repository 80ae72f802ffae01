"""Times of a ROS 2 bag's messages, on one clock."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.core.errors import ResultFileError

from .bag import SECOND
from .run import Floats

Integers: TypeAlias = NDArray[np.int64]
APART = 0.5
"""Clocks of stamps and of the recorder that differ by more [s] are two clocks."""
LATE = 1.0
"""Messages at most so late [s] are put back in order; more is a clock that was set."""
PARTS = 40
"""Parts of a drive in which two clocks are compared."""
BEND = 0.02
"""Distance from a line that is allowed between clocks [s]."""
STEADY = 1e-3
"""Difference of two clocks' rates that is reported."""


class Topic(NamedTuple):
    """Messages of a topic: stamps (N,) (0 if absent) and times of receipt (N,) [ns], numbers (N,
    width) in the order of its role's reader, and the frame of the last one.
    """

    name: str
    stamps: Integers
    receipt: Integers
    values: Floats
    frame: str


def clocks_of(parts: Mapping[str, Topic], remarks: list[str]) -> dict[str, Integers]:
    """Times [ns] of each topic's messages, all on one clock; appends remarks on them.

    It is the clock of the stamps of the topic with the most messages.  Topics without stamps, or
    with stamps of another clock, use times of receipt, converted to that clock.
    """
    late = {
        role: float(np.median(part.receipt - part.stamps)) / SECOND
        for role, part in parts.items()
        if np.sum(part.stamps == 0) <= 1
    }
    leader = max(late, key=lambda role: len(parts[role].stamps), default=None)
    if leader is None:
        return {role: _clock(part, part.receipt, False, remarks) for role, part in parts.items()}
    stamped = [role for role, lag in late.items() if abs(lag - late[leader]) <= APART]
    clocks = {role: _clock(parts[role], parts[role].stamps, True, remarks) for role in stamped}
    rest = [role for role in parts if role not in stamped]
    onto = _onto_stamps(parts[leader], remarks) if rest else None
    for role in rest:
        receipt = parts[role].receipt if onto is None else onto(parts[role].receipt)
        clocks[role] = _clock(parts[role], receipt, False, remarks)
    return clocks


def _onto_stamps(topic: Topic, remarks: list[str]) -> Callable[[Integers], Integers] | None:
    """Map from the recorder's clock to the clock of ``topic``'s stamps; None if they are equal.

    It is the straight line through the least delayed message in each of `PARTS` parts of the drive.
    While the stamps do not advance, as in a paused simulation, the recorder's clock is stopped.
    Raises ResultFileError if these messages are not on a line.
    """
    order = np.argsort(topic.receipt, kind="stable")
    r0, s0 = topic.receipt[order[0]], topic.stamps[order[0]]
    r, s = (topic.receipt[order] - r0) / SECOND, (topic.stamps[order] - s0) / SECOND
    if not s[-1] > 0:
        return None
    running, stood = r, np.zeros_like(r)
    for _ in range(2):
        waited = np.diff(r) - running[-1] / s[-1] * np.diff(s)
        stood = np.concatenate(([0.0], np.cumsum(np.where(waited > APART, waited, 0.0))))
        running = r - stood
    rate = running[-1] / s[-1]
    parts = np.array_split(np.arange(len(r)), max(min(PARTS, len(r) // 5), 2))
    for _ in range(3):
        late = running - rate * s
        least = np.array([part[np.argmin(late[part])] for part in parts if part.size])
        rate += np.polyfit(s[least], late[least], 1)[0] if len(least) > 2 else 0.0
    late = (running - rate * s)[least]
    if np.abs(late - np.median(late)).max() > BEND:
        ends = np.sort(np.diff(s[least]) / np.diff(r[least]))
        raise ResultFileError(
            f"{topic.name}: its stamps run at {ends[0]:.3g} to {ends[-1]:.3g} seconds in a second "
            "of the recorder's clock, and another topic has no stamps of that clock: their times "
            "cannot be compared. Record stamped commands (TwistStamped), or let the simulation run "
            "at one rate."
        )
    offset = float(np.median(late))
    apart = abs(float(r0 - s0) / SECOND + offset) > APART
    if not (apart or stood[-1] > 0 or abs(rate - 1) * s[-1] > BEND):
        return None
    said = ["stamps and the recorder are on two clocks: times of receipt are moved to the stamps'"]
    if abs(rate - 1) > STEADY:
        said.append(f"that clock runs at {1 / rate:.4g} of the recorder's")
    if stood[-1] > 0:
        said.append(f"it stands still for {stood[-1]:.2g} s in all")
    remarks.append(f"{'; '.join(said)}.")

    def onto(receipt: Integers) -> Integers:
        seconds = (receipt - r0) / SECOND
        seconds = (seconds - np.interp(seconds, r, stood) - offset) / rate
        return s0 + np.rint(seconds * SECOND).astype(np.int64)

    return onto


def _clock(topic: Topic, clock: Integers, stamped: bool, remarks: list[str]) -> Integers:
    """Checked times (N,) [ns] of a topic's messages; appends remarks on them."""
    late = (topic.receipt - topic.stamps) / SECOND
    seen = f"{1e3 * np.median(late):.3g} ms after its stamps, {1e3 * late.max():.3g} ms at most"
    if abs(np.median(late)) > APART:
        seen = "by another clock than that of its stamps"
    about = (
        f"recorded {seen}; times are the stamps"
        if stamped
        else "times are those of the recorder, so an identified delay lacks a message's way to it"
    )
    step = np.diff(np.sort(clock)) / SECOND
    remarks.append(
        f"{topic.name}: {len(clock)} messages in {step.sum():.4g} s, {about}; the longest gap is "
        f"{step.max(initial=0.0):.3g} s."
    )
    behind = (np.maximum.accumulate(clock) - clock) / SECOND
    if behind.max() > LATE:
        at = int(np.argmax(behind))
        raise ResultFileError(
            f"{topic.name}: time goes back by {behind[at]:.4g} s at message {at + 1}: a clock was "
            "set, or two drives are in one bag. Cut the bag there, as by `ros2 bag convert`."
        )
    if behind.max() > 0:
        remarks.append(
            f"{topic.name}: {np.sum(np.diff(clock) < 0)} messages came out of order, by "
            f"{1e3 * behind.max():.3g} ms at most; sorted by time."
        )
    return clock
