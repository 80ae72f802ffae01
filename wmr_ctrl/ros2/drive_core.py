"""Decisions of ``wmr_drive``: from odometry and ticks to the command for the base.

Each message is a sample: its stamp is the law's time.  If the law's memory becomes invalid (missing
odometry, a jump of pose or clock, a stop), the base is brought to rest; the reference waits, and
after CALM consistent messages the law restarts at the waiting reference.  Nothing here depends on
ROS: the node passes on what arrived and when.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from wmr_ctrl.control.filter.filter import STANDING
from wmr_ctrl.control.filter.gate import Gated, GateSettings
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.core.errors import ScenarioError, WmrError
from wmr_ctrl.core.fields.orientation import theta_of

from .clocks import BACK, Clocks, Moment, longest_pause
from .compiled_system import NONE, PAIR, Gate
from .drive_law import DesiredMotion, DriveLaw, check_follows, path_motion
from .intake import Intake, Pace, is_rotation
from .native import NS, in_ns

CALM = 3
"""Messages that must agree with each other before the law acts again."""
OFF = 0.75
"""Deviation [periods] from the law's time up to which samples are still counted one by one."""
EXACT = 1_000
"""Distance [ns] from the grid of samples within which a stamp is on it."""
ROUNDED = 2
"""Difference [ns] from the period that counts as none: stamps are whole nanoseconds."""
LATEST = 1.5
"""Periods after which a torque has acted for too long."""
NO_ODOMETRY, JUMPED, STOPPED, NOT_FINITE = "no-odometry", "pose-jump", "stopped", "law-not-finite"
NO_PATH, NEW_PATH, ARRIVED = "no-path", "new-path", "arrived"
MISSED, DOUBLED, BETWEEN = "period-missed", "period-doubled", "between-samples"
Message = tuple[float, float, float, float, float, float, float, float]
NOTHING: Message = (0.0,) * 8


@dataclass(frozen=True, kw_only=True)
class DriveSettings:
    """Gate of the drive, its frames, and the largest pose jump [m, rad] beyond its motion.

    ``path``: the reference comes as a path, not from the scenario.
    """

    gate: GateSettings = field(default_factory=GateSettings)
    odometry_frame: str = "odom"
    base_frame: str = "base_link"
    jump: tuple[float, float] = (0.1, 0.2)
    path: bool = False


class DriveCore:
    """Law, gate, intake and clocks of a drive node.

    ``last``: the command sent last.  ``e``: tracking error of the last sample [m, m, rad].
    ``held``: why the base is kept at rest, "" while it drives.  ``counts``: number of events by
    name.  ``oldest``: largest age of odometry at a sample [s], which its reader resets to 0.
    """

    def __init__(self, setup: Setup, settings: DriveSettings) -> None:
        """Compile law, reference and gate.  Raises ScenarioError, CompilerError."""
        self.setup, self.settings = setup, settings
        self.period, timeout = setup.scenario.clock.control, settings.gate.odometry_timeout
        if timeout < LATEST * self.period:
            raise ScenarioError(
                f"odometry_timeout = {timeout:g} s is too short for clock.control = "
                f"{self.period:g} s: no sample would be in time. It must be at least {LATEST:g} "
                "periods."
            )
        self._law = DriveLaw(setup)
        self._gate = Gate(setup.scenario, settings.gate) if setup.takes_velocity else None
        if settings.path:
            check_follows(setup.scenario)
        self._scenario_motion = None if settings.path else DesiredMotion(setup.scenario)
        frames = f"{settings.odometry_frame} -> {settings.base_frame}"
        self.measured = Intake(in_ns(timeout), NOTHING, frames, named=True)
        self.clocks = Clocks(longest_pause(timeout, self.period))
        self._pace = Pace(in_ns(self.period))
        self.counts: dict[str, int] = {}
        self.oldest = 0.0
        self.stop, self._in_flight = False, _in_flight(setup)
        self.start()

    def start(self) -> None:
        """Reset: the reference at its start, no message, latched if ~/stop is true."""
        self.measured.forget()
        self._pace.forget()
        self.clocks.start()
        if self._gate:
            self._gate.start()
        self.last, self.e = Gated(PAIR, ()), (0.0, 0.0, 0.0)
        self._latched, self._reset = self.stop, False
        self._near = 0.0
        self._seen: tuple[int, Message] | None = None
        self._sent_at: tuple[int, int] | None = None
        self._points: list[tuple[float, float]] = []
        self.problem = ""
        self._lay(self._scenario_motion)
        self._calm, self.held = 0, "" if self._motion else NO_PATH
        if self.stop:
            self._hold(STOPPED)

    def _lay(self, motion: DesiredMotion | None) -> None:
        self._motion, self._sample = motion, -1
        self._origin: int | None = None

    # -- what comes in ------------------------------------------------------------------------

    def see(self, now: Moment) -> tuple[str, ...]:
        """Check the clocks; returns what happened to them, for the report."""
        happened = self.clocks.see(now)
        if BACK in happened:
            self.measured.forget()
            self._pace.forget()
            self._seen = None
            self._hold(BACK)
        return happened

    def odometry(
        self, message: Message, stamp: int, frame: str, child: str, now: Moment
    ) -> tuple[str, Gated | None]:
        """Take a message; returns the reason if it is refused ("" if not), and the command sent, if
        any.

        ``message``: x, y, quaternion, v, omega; ``stamp`` [ns]; the pose is in ``frame``, the twist
        in ``child``.
        """
        reason = "" if is_rotation(*message[2:6]) else "not a rotation"
        reason = reason or ("" if stamp else "without a stamp")
        if reason:
            return self.measured.refuse(reason), None
        reason = self.measured.take(message, stamp, f"{frame} -> {child}", now)
        if reason:
            return reason, None
        self._compare(stamp, message)
        place = self._place(stamp)
        if place is None:
            return "", None
        return "", self._sampled(*place, stamp, now)

    def follow(self, points: Sequence[tuple[float, float]], frame: str) -> str:
        """Store a path, which starts once the base rests; returns the reason if it is refused, else
        "".
        """
        if not self.settings.path:
            return "the reference is the scenario's"
        if frame != self.settings.odometry_frame:
            return f"it is in {frame!r}, not in {self.settings.odometry_frame!r}"
        if not all(math.isfinite(part) for point in points for part in point):
            return "not a number"
        self._points = list(points)
        self._hold(NEW_PATH)
        return ""

    def halt(self, stop: bool, now: Moment) -> Gated | None:
        """Process a message on ~/stop; true stops immediately and latches."""
        self.stop = stop
        if not stop:
            return None
        self._latched = True
        self._hold(STOPPED)
        return self._rest(now)

    def reset(self) -> bool:
        """Release the latch; False while ~/stop is true, which keeps the base stopped."""
        if self.stop:
            return False
        self._latched, self._reset = False, True
        return True

    def tick(self, now: Moment) -> Gated | None:
        """The command for the base if odometry is late; None while it arrives in time."""
        patience = self.settings.gate.odometry_timeout
        if self._gate is None and not now.simulated:
            patience = min(patience, LATEST * self.period)
        if 0 <= self.measured.age(now) <= patience:
            return None
        if self._seen and self.held not in (NO_ODOMETRY, STOPPED):
            self._hold(NO_ODOMETRY)
        recent = self._sent_at and now.steady - self._sent_at[1] < 0.75 * self.period / NS
        return None if recent else self._rest(now)

    # -- what is made of it -------------------------------------------------------------------

    def _hold(self, reason: str) -> None:
        """Bring the base to rest; the law restarts when the cause is over."""
        self.held, self._calm, self._origin = reason, max(CALM, self._in_flight), None
        self._count(reason)

    def _count(self, what: str, times: int = 1) -> None:
        self.counts[what] = self.counts.get(what, 0) + times

    def _compare(self, stamp: int, message: Message) -> None:
        """Bring the base to rest if a message does not follow from the one before."""
        before, self._seen = self._seen, (stamp, message)
        if before is None:
            return
        passed = stamp - before[0]
        if passed > self.measured.timeout:
            self._hold(NO_ODOMETRY)
        elif self._leaps(before[1], message, passed * NS):
            self._hold(JUMPED)

    def _leaps(self, before: Message, message: Message, passed: float) -> bool:
        """True if the pose moved farther than the larger of both speeds and the tolerance allow."""
        speed, turning = (max(abs(before[i]), abs(message[i])) for i in (6, 7))
        way = math.hypot(message[0] - before[0], message[1] - before[1])
        most, turned = self.settings.jump
        angles = [theta_of(item[2:6], math.atan2) for item in (before, message)]
        turn = abs(math.remainder(angles[1] - angles[0], math.tau))
        return way > most + 2 * speed * passed or turn > turned + 2 * turning * passed

    def _place(self, stamp: int) -> tuple[int, float] | None:
        """Index of the law's period and the time after its start [s]; None if no sample is due."""
        following = self._sample + 1
        if self._origin is None:
            self._origin = stamp - in_ns(following * self.period)
            self._pace.restart()
        if not self._pace.due(stamp):
            self._count(BETWEEN)
            return None
        since = stamp - self._origin
        if abs(since - in_ns(following * self.period)) * NS <= OFF * self.period:
            sample = following
        else:
            sample = max(self._sample, math.floor(since * NS / self.period + 0.5))
        rest = since - in_ns(sample * self.period)
        return sample, 0.0 if abs(rest) <= EXACT else rest * NS

    def _sampled(self, sample: int, rest: float, stamp: int, now: Moment) -> Gated:
        if self._calm:
            self._calm -= 1
        if self._points and self.last.command == PAIR:
            self._begin_path()
        if self._motion is None and not (self._calm or self._latched or self._points):
            self.held = NO_PATH
        if self._calm or self._latched or self._points or self._motion is None:
            self._origin = None
            return self._rest(now)
        if self.held or self._sample < 0:
            self._law.start(self.last.command)
            self._near = self._motion.at(sample, rest)[2]  # turns of before are no error
        missed = sample - self._sample - 1
        self._sample, self.held = sample, ""
        return self._act(self._motion, rest, missed, (stamp, now))

    def _begin_path(self) -> None:
        points, self._points, self.problem = self._points, [], ""
        try:
            self._lay(path_motion(self.setup.scenario, self.setup.name, points))
        except WmrError as error:
            self._lay(None)
            self.problem, self.held = " ".join(str(error).split()), NO_PATH

    def _act(
        self, motion: DesiredMotion, rest: float, missed: int, at: tuple[int, Moment]
    ) -> Gated:
        stamp, now = at
        message, sample = self.measured.value, self._sample
        wish = self._law.wish(motion.at(sample, rest), message, self._near)
        if not all(map(math.isfinite, (*wish.command, wish.theta))):
            self._hold(NOT_FINITE)
            return self._rest(now)
        self._near, self.e = wish.theta, wish.e
        self.oldest = max(self.oldest, self.measured.age(now))
        flags = [MISSED] if missed > 0 else []
        self._count(MISSED if missed > 0 else DOUBLED, abs(missed))
        if motion.arrival is not None and sample * self.period + rest >= motion.arrival:
            flags.append(ARRIVED)
        gated = Gated(wish.command, ())
        if self._gate:
            gated = self._passed(wish.command, 0.0, stamp, now)
        self._law.remember(gated.command)
        self._sent_at = stamp, now.steady
        self.last = Gated(gated.command, (*gated.flags, *flags))
        return self.last

    def _elapsed(self, stamp: int, now: Moment) -> float:
        """Time since the gate's last step [s], by stamps if that was a sample; 0: the period."""
        if self._sent_at is None:
            return 0.0
        before, steady = self._sent_at
        passed = stamp - before if stamp and before else now.steady - steady
        if abs(passed - in_ns(self.period)) <= ROUNDED:
            return 0.0
        return passed * NS if passed else STANDING

    def _passed(self, command: tuple[float, float], age: float, stamp: int, now: Moment) -> Gated:
        """Pass a command through the gate; ``stamp`` is 0 if it does not belong to a sample."""
        assert self._gate
        gated = self._gate.step(
            command, age, self.measured.value[6:], self.measured.age(now),
            self._elapsed(stamp, now), stop=self.stop, reset=self._reset,
        )  # fmt: skip
        self._reset = False
        if STOPPED in gated.flags and not self._latched:
            self._latched = True
            self._hold(STOPPED)
        return gated

    def _rest(self, now: Moment) -> Gated:
        """Bring the base to rest: velocities follow the gate's ramp, torques become 0."""
        gated = Gated(PAIR, ())
        if self._gate:
            gated = self._passed(PAIR, NONE, 0, now)
        self._sent_at = 0, now.steady
        held = self.held or NO_ODOMETRY
        flags = tuple(flag for flag in gated.flags if flag not in ("no-command", held))
        self.last = Gated(gated.command, (*flags, held))
        return self.last


def _in_flight(setup: Setup) -> int:
    """Number of earlier torques that may still act at a restart, from the guard's delay and lag.

    An empty memory assumes that they are 0, which is true after that many zeros were sent.
    """
    if not setup.scenario.guard.enabled:
        return 0
    drives = setup.scenario.actuator
    return setup.guard.commands(setup.scenario.clock, drives.delay, drives.lag) + 1
