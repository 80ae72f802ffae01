"""Wheel encoders: whole counts of each wheel's rotation, and the velocity computed from them.

Source: quadrature encoders on the wheels, read at every sample. The controller knows the counts and
the wheels' size as believed. The difference of counts over a window gives the mean velocity in it;
the time between counts resolves slow motion better, at the price of an unknown age.
"""

from __future__ import annotations

import math
from dataclasses import replace

from wmr_ctrl.core.errors import ArgumentError, ScenarioError
from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import MEASURED_VELOCITY, PATH, POSE, SAMPLE, SKID, VELOCITY, Signal
from wmr_ctrl.core.symbolic import ca

from .effect import Bound, Effect, EffectRole, Scenario, on_axes
from .gyro import axes_without_gyro
from .history import MOST_REMEMBERED, history
from .model.system import (
    Number,
    Output,
    Parameters,
    Port,
    System,
    outputs,
    port,
    ports,
    stack,
)
from .wheels import Wheels, misread, true_wheels

DIFFERENCE, TIME = "difference", "time"
COUNTS = Signal("wheel_counts", "1", "whole counts of the wheels' turn (right, left)", 2)
MOVED = Signal("wheel_moved", "1", "counts of the wheels since the sample before (right, left)", 2)
TURN = Signal("encoder_turn", "1", "turn of the wheels at the previous sample, in counts", 2)
EDGE = Signal("encoder_edge", "1", "turn at which the last count came, in counts", 2)
SINCE = Signal("encoder_since", "s", "time from the last count to the previous sample", 2)
SPEED = Signal("encoder_speed", "1/s", "counts over time of the previous sample", 2)

LONG = 1e9
"""Time since a last count that there was not yet [s]: the first one shows no speed."""


class Encoder(Section, key="encoder"):
    """Counts per turn, and how the velocity is computed from counts; no encoders if omitted."""

    counts: float | None = quantity(
        None, "1", "counts in one turn of a wheel, all four edges counted", above=0
    )
    window: float = quantity(
        0.0,
        "s",
        "time over which counts are differenced, a multiple of clock.control; 0: one period",
        minimum=0,
        multiple_of="clock.control",
        most=MOST_REMEMBERED,
    )
    method: str = quantity(
        DIFFERENCE,
        "1",
        "counts over a window, or one count over the time that it took",
        options=(DIFFERENCE, TIME),
    )
    bits: int = quantity(32, "1", "bits of the counters that a C package reads: 16 or 32")

    def relate(self) -> None:
        """Check that counts are integer, and that counters have 16 or 32 bits."""
        if self.bits not in (16, 32):
            raise ScenarioError(
                f"encoder.bits = {self.bits!r} must be 16 or 32. For a counter with other bits, "
                "add up its steps in a variable of 32 bits and set encoder.bits = 32."
            )
        if self.counts is not None and not self.counts.is_integer():
            raise ScenarioError(
                f"encoder.counts = {self.counts!r} must be a whole number: so many edges pass in "
                f"one turn of a wheel. The nearest is {max(1, round(self.counts))}."
            )


def build(scenario: Scenario) -> System:
    """Sampled System: path length, orientation, skid and sample number to measured velocity."""
    encoder = scenario.section(Encoder)
    path, theta, skid, sample = ports((PATH, POSE[2], SKID, SAMPLE))
    p, first = Parameters(scenario), sample.sym == 0
    turns = turned(scenario, p, path.sym, theta.sym + skid.sym)
    counts = ca.floor(turns)
    state: tuple[Port, ...]
    if encoder.method == DIFFERENCE:
        seen = history(COUNTS, counts, first, periods_in_window(scenario))
        rate = _per_second(scenario, p, seen.aged[0] - seen.aged[-1])
        state, update = seen.state, seen.update
    else:
        rate, state, update = _timed(turns, first, p.take("clock.control"))
    velocity = velocity_of(rate, p)
    return System(
        "encoder",
        "wheel encoders",
        inputs=(path, theta, skid, sample),
        state=state,
        params=p.ports,
        update=update,
        outputs=outputs(MEASURED_VELOCITY, velocity),
        diagnostics=(Output(COUNTS, counts),),
    )


def reader(scenario: Scenario) -> System:
    """Sampled System: counts since the last sample to velocity, for C code that receives counts.

    Its output equals `build`'s on the axes without gyro: sums of integers are exact. Raises
    ArgumentError if the time between counts is needed, which counts at samples do not contain, and
    if a wheel within the limits can move by half of the counter's range in a sample.
    """
    if scenario.section(Encoder).method == TIME:
        raise ArgumentError(
            "encoder.method = time needs the times at which counts came, but a controller gets "
            "counts only at its samples. Use encoder.method = difference."
        )
    _check_range(scenario)
    p, moved = Parameters(scenario), port(MOVED)
    earlier = ports(
        replace(MOVED, name=f"{MOVED.name}_{k}", meaning=f"{MOVED.meaning}, {k} samples ago")
        for k in range(1, periods_in_window(scenario))
    )
    recent = [moved.sym, *(item.sym for item in earlier)]
    velocity = velocity_of(_per_second(scenario, p, sum(recent[1:], moved.sym)), p)
    return System(
        "encoder_reader",
        "velocity from counts",
        inputs=(moved,),
        state=earlier,
        params=p.ports,
        update=stack(recent[:-1]),
        outputs=tuple(Output(VELOCITY[i], velocity[i]) for i in axes_without_gyro(scenario)),
        period=scenario.clock.control,
    )


def _check_range(scenario: Scenario) -> None:
    """Raise ArgumentError if a step of counts within the limits is ambiguous."""
    encoder, robot, (v, omega) = scenario.section(Encoder), scenario.robot, scenario.limits.v_u1
    turns = (v + robot.l * omega) * scenario.clock.control / (2 * math.pi * robot.r)
    step, half = turns * float(encoder.counts or 0), 2 ** (encoder.bits - 1)
    if step >= half:
        raise ArgumentError(
            f"At limits.v_u1 a wheel turns by {step:.4g} counts in a control period, but with "
            f"encoder.bits = {encoder.bits} only steps below {half} counts show their direction. "
            "Read a counter of more bits, sample more often, or lower the limits."
        )


def _per_second(scenario: Scenario, p: Parameters, turned: ca.SX) -> ca.SX:
    """Counts over time (2,) [1/s], for counts in the window."""
    return turned / (p.take("clock.control") * periods_in_window(scenario))


def turned(scenario: Scenario, p: Parameters, path: ca.SX, theta: ca.SX) -> ca.SX:
    """Wheels' rotation (2,) since the start [counts], for path length [m] and theta [rad]."""
    radius, arm = p.take("robot.r"), p.take("robot.l")
    if not scenario.section(Wheels).believed:
        radius, arm = true_wheels(p)
    way = ca.vertcat(path + arm * theta, path - arm * theta)
    return way / radius * (p.take("encoder.counts") / (2 * ca.pi))


def velocity_of(rate: ca.SX, p: Parameters) -> ca.SX:
    """(v1, omega) for counts over time (2,) [1/s] on wheels of the believed size."""
    speed = rate * (2 * ca.pi * p.take("robot.r") / p.take("encoder.counts"))
    return ca.vertcat(speed[0] + speed[1], (speed[0] - speed[1]) / p.take("robot.l")) / 2


def periods_in_window(scenario: Scenario) -> int:
    """Control periods over which counts are differenced."""
    return max(1, round(scenario.section(Encoder).window / scenario.clock.control))


def _timed(turn: ca.SX, first: ca.SX, period: ca.SX) -> tuple[ca.SX, tuple[Port, ...], ca.SX]:
    """Counts per time [1/s] between the last counts of two samples; state and update.

    A wheel's speed is assumed constant over a sample to find the time of its last count.  Without a
    new count the speed is at most one count over the elapsed time.
    """
    state = ports((TURN, EDGE, SINCE, SPEED))
    starts = (turn, ca.floor(turn), ca.SX(LONG), ca.SX(0))
    pairs = zip(starts, state, strict=True)
    before, edge, since, speed = (ca.if_else(first, start, item.sym) for start, item in pairs)
    moved = turn - before
    came = ca.logic_and(ca.floor(turn) != ca.floor(before), ca.logic_not(first))
    reached = ca.floor(turn) + (moved < 0)
    share = (turn - reached) / ca.if_else(came, moved, 1)
    late = ca.if_else(came, share * period, since + period)
    passed = ca.if_else(came, since + period - late, since + period)
    slow = ca.fmin(ca.fabs(speed), 1 / passed)
    held = ca.if_else(speed < 0, -slow, slow)
    rate = ca.if_else(came, (reached - edge) / ca.fmax(passed, 1e-12), held)
    return rate, state, ca.vertcat(turn, ca.if_else(came, reached, edge), late, rate)


def check(scenario: Scenario) -> None:
    """Check that no other sensor averages the velocity."""
    encoder = scenario.section(Encoder)
    mean = scenario.sensor.velocity_window
    if encoder.counts is not None and mean > 0:
        raise ScenarioError(
            f"sensor.velocity_window = {mean!r} s and encoder.counts = {encoder.counts:g} both "
            "make the measured velocity. Leave one of them out; encoder.window averages counts."
        )


def bound(scenario: Scenario) -> Bound:
    """A mean over the window, with an error of one count of each wheel and of the wheels' size.

    The whole parts of two numbers differ by the numbers' difference +-1 at most, for any phase of
    the counts (`rounded_by`).

    With the time between counts each wheel gives a mean of its speed (the time of a count is
    computed from the rotation at both ends of a sample), but over its own window.  Half their sum
    and difference then mix v1 and omega.  With the right wheel's mean E and the left one's E', v1
    has an error of l (E omega - E' omega)/2, up to l omega_u1/2 if friction stops the turn between
    both.  The error of omega is (E v1 - E' v1)/(2 l), up to v_u1/(2 l), for any number of counts.
    The windows begin at the last count of an earlier sample, however long ago that was.  A wheel
    may also turn by nearly a count without showing it, which equals the error of a difference over
    one period.  So neither an nbar nor a window can be guaranteed, and the bound is void.
    """
    encoder, robot = scenario.section(Encoder), scenario.robot
    if encoder.method == TIME:
        return Bound(
            void="encoder.method = time: each wheel's speed is a mean over its own time, which "
            "depends on that speed, while the guard relies on one fixed window."
        )
    window = periods_in_window(scenario) * scenario.clock.control
    counts = float(encoder.counts or math.inf)
    rounded, off = rounded_by((robot.r, robot.l), counts, window), misread(scenario)
    seen = Bound(nbar=(rounded[0] + off[0], rounded[1] + off[1]), window=(window, window))
    return on_axes(axes_without_gyro(scenario), seen)


def rounded_by(
    believed: tuple[Number, Number], counts: Number, window: Number
) -> tuple[Number, Number]:
    """Quantisation error of v1 [m/s] and omega [rad/s] from differences of whole ``counts``.

    Each wheel's speed has an error below 2 pi r/(N w); v1 has the same, and omega that over l
    (ledger: world.encoder.*).  ``believed``: (r, l) [m]; ``window``: w [s]; both are numbers or
    symbols.
    """
    r, half_track = believed
    count = 2.0 * math.pi * r / (counts * window)
    return count, count / half_track


ENCODER = Effect(
    "encoder",
    EffectRole.SENSOR,
    Encoder,
    build,
    bound,
    switches=("counts",),
    shape=("encoder.window", "clock.control"),
    check=check,
)
