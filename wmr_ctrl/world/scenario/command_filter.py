"""Section of the command filter: the base that it assumes, and how commands are limited."""

from collections.abc import Callable, Iterable
from typing import TypeAlias

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.fields.values import Pair, is_by_axis

from .sections import check_intervals

FILTERS = ("none", "clip", "governor", "band")
LOOPS = ("first-order", "second-order", "pi")
CHANNELS = ("body", "wheels")
SCALES = ("curvature", "axes", "turn", "drive")
MOST_PERIODS = 64
"""Most control periods of delay, age and losses that the governor counts through."""


def quoted(kinds: Iterable[str]) -> str:
    """Kinds of filters as they are written in a scenario."""
    return " or ".join(f'"{kind}"' for kind in kinds)


BY_AXIS = ("tau", "gain", "delay", "damping", "frequency")
"""Bounds that may be stated separately for v and omega."""
FIRST_ORDER = ("first-order", "first-order")
Intervals: TypeAlias = Pair | tuple[Pair, Pair]
"""An interval of both axes, or one of v and one of omega."""


class Filter(Section, key="filter"):
    """Filter of commanded velocities that keeps |v1|, |omega| within limits.v_u1.

    The base follows its command by a first-order lag: tau v' = K u + d - v, whose time constant,
    gain and push are anywhere within their intervals and may vary.  Samples are clock.control
    apart.  ``clip`` needs only the upper end of ``gain`` and ``d``, and is valid for every base
    that never overshoots.  ``governor`` needs all of them, and uses odometry to allow more speed.
    One interval applies to both axes; of two, the first is for v and the second for omega, as
    `intervals` gives them.
    """

    kind: str = quantity("none", "1", "how commands are limited", options=FILTERS)
    loop: tuple[str, str] = quantity(
        FIRST_ORDER, "1", "how the base follows its command", kind="text", size=2, options=LOOPS,
        alike=True,
    )  # fmt: skip
    tau: Intervals | None = quantity(
        None, "s", "bounds of the speed loop's time constant", above=0, size=2,
        usual=(1e-3, 20), by_axis=True,
    )  # fmt: skip
    gain: Intervals = quantity(
        (1.0, 1.0), "1", "bounds of the steady-state speed divided by the command", above=0,
        usual=(0.1, 10), by_axis=True,
    )  # fmt: skip
    d: tuple[float, float] = quantity(
        (0.0, 0.0), "m/s, rad/s",
        "steady speed that a push, or an error of the command, alone would cause", minimum=0,
    )  # fmt: skip
    odometry: tuple[float, float] | None = quantity(
        None, "m/s, rad/s", "bound of the odometry's error; left out: no odometry is used",
        minimum=0, size=2,
    )  # fmt: skip
    age: float = quantity(0.0, "s", "largest age of odometry", minimum=0, usual=(0, 1))
    delay: Intervals = quantity(
        (0.0, 0.0), "s", "bounds of a command's delay, which may vary", minimum=0,
        usual=(0, 1), by_axis=True,
    )  # fmt: skip
    losses: int = quantity(0, "1", "largest number of consecutive lost commands", minimum=0)
    jitter: float = quantity(
        0.0, "s",
        "largest deviation of a sample from the clock's period; of a band's from its beat",
        minimum=0, usual=(0, 1),
    )  # fmt: skip
    hold: float = quantity(
        0.0, "s", "time for which the base keeps its last command before it stops",
        minimum=0, usual=(0, 10),
    )  # fmt: skip
    scale: str = quantity(
        "curvature", "1",
        "scale both axes by one factor, each by its own, or turning or driving first",
        options=SCALES,
    )  # fmt: skip
    channels: str = quantity(
        "body", "1", "speeds with a loop of their own: v and omega, or each wheel", options=CHANNELS
    )
    wheel_speed: float | None = quantity(
        None, "m/s",
        "limit of each wheel's speed over the ground, for wheels whose loops are alike", above=0,
    )  # fmt: skip
    damping: Intervals | None = quantity(
        None, "1", "bounds of a second-order loop's damping ratio", above=0, size=2, by_axis=True
    )
    frequency: Intervals | None = quantity(
        None, "rad/s", "bounds of a second-order loop's natural frequency", above=0, size=2,
        by_axis=True, usual=(0.1, 500),
    )  # fmt: skip
    mass: tuple[float, float] | None = quantity(
        None, "kg", "bounds of the mass, for PI loops", above=0, size=2
    )
    inertia: tuple[float, float] | None = quantity(
        None, "kg.m2", "bounds of the inertia, for PI loops", above=0, size=2
    )
    kp: tuple[float, float] | None = quantity(
        None, "N.s/m", "bounds of a PI loop's gain, both wheels together, at the rim", above=0,
        size=2,
    )  # fmt: skip
    ki: tuple[float, float] | None = quantity(
        None, "N/m", "bounds of its integral gain, both wheels together, at the rim", above=0,
        size=2,
    )  # fmt: skip
    friction: tuple[float, float] = quantity(
        (0.0, 0.0), "N.s/m", "bounds of the viscous friction", minimum=0
    )
    push: tuple[float, float] = quantity(
        (0.0, 0.0), "N, N.m", "largest push on a base with PI loops", minimum=0
    )
    slew: tuple[float, float] | None = quantity(
        None, "m/s2, rad/s2", "fastest change of commands that a linear loop's clip allows",
        size=2, above=0,
    )  # fmt: skip
    least: bool = quantity(
        False, "1", "send 0 or the least command that acts for one within the base's dead band"
    )
    changing: bool = quantity(
        False, "1", "each step is told the limits in force; those of [limits] are the widest"
    )
    free_error: float | None = quantity(
        None, "m", "largest error of the free distances that a step is told; left out: none is",
        minimum=0,
    )  # fmt: skip
    free_age: float = quantity(0.2, "s", "largest age of free distances", minimum=0, usual=(0, 2))
    nearing: float = quantity(
        0.0, "m/s", "largest speed at which what is in the way comes nearer", minimum=0
    )
    rest: float | None = quantity(
        None, "s", "time after which the base stands, and holds, once commands of 0 act",
        minimum=0, usual=(0, 10),
    )  # fmt: skip
    decel: tuple[float, float] | None = quantity(
        None, "m/s2, rad/s2", "least deceleration of a base that never passes its command, for a "
        "clip that stops", size=2, above=0,
    )  # fmt: skip
    leave: int = quantity(
        1, "1", "releases that come too early, for which a stop keeps enough distance", minimum=0
    )
    trust: bool = quantity(False, "1", "allow runs in which a hypothesis does not hold")

    def relate(self) -> None:
        """Check that intervals are ordered, and that a filter has the numbers that it needs."""
        of_wheels = ("mass", "inertia", "kp", "ki", "friction")
        check_intervals(self, dict.fromkeys((*BY_AXIS, *of_wheels), "it"))
        for axis in (0, 1):
            self._relate_loop(axis)
        self._relate_axes()
        if self.kind == "band":
            self._relate_band()
        if self.slew is not None:
            self._relate_slew()
        if self.is_told:
            self._relate_told()
        stops = self.kind == "none" or (self.kind == "clip" and self.free_error is not None)
        if self.decel is not None and not stops:
            raise ScenarioError(
                'filter.decel is for filter.kind = "clip" with filter.free_error, which stops by '
                "it: nothing else uses it. Leave it out."
            )
        if self.scale == "axes" and (self.channels == "wheels" or self.wheel_speed):
            raise ScenarioError(
                'filter.scale = "axes" limits v and omega separately, which does not fit wheels '
                'that are limited individually. Use "curvature", "turn" or "drive".'
            )
        if self.kind == "governor" and self.tau is None:
            raise ScenarioError(
                "filter.tau is missing: the governor relies on bounds of the time constant with "
                "which the base follows its command. Give tau = [low, high] [s], or use "
                'filter.kind = "clip", which holds for every base that never overshoots.'
            )
        for low, high in self.intervals("tau") if self.tau is not None else ():
            if high > 1e6 * low:
                raise ScenarioError(
                    f"filter.tau = [{low!r}, {high!r}] spans more than a factor of 1e6, too wide "
                    "for any guarantee. Narrow the interval."
                )

    @property
    def is_told(self) -> bool:
        """True if steps receive limits or distances, or if the filter relies on the base's
        brake.
        """
        told = self.changing or self.free_error is not None or self.rest is not None
        return told and self.kind != "none"

    @property
    def reads(self) -> tuple[str, ...]:
        """Keys of the robot that the filter depends on."""
        rims = self.channels == "wheels" or self.wheel_speed or "pi" in self.loop
        return ("robot.l",) if self.kind != "none" and rims else ()

    def interval(self, name: str) -> tuple[float, float]:
        """Bounds called ``name``, which the loop needs and `relate` has checked."""
        low, high = getattr(self, name)
        return low, high

    def intervals(self, name: str) -> tuple[Pair, Pair]:
        """Bounds called ``name`` of v and of omega, which `relate` has checked."""
        stated = getattr(self, name)
        linear, angular = stated if is_by_axis(stated) else (stated, stated)
        return linear, angular

    def each(self, name: str, change: Callable[[Pair], Pair]) -> Intervals:
        """Value of ``name`` after a change to its interval, or to both intervals."""
        linear, angular = map(change, self.intervals(name))
        return (linear, angular) if is_by_axis(getattr(self, name)) else linear

    def place(self, name: str, axis: int, end: int) -> str:
        """Key of an end, 1 or 2, of an axis' bounds called ``name``."""
        own = f"[{axis + 1}]" * is_by_axis(getattr(self, name))
        return f"filter.{name}{own}[{end}]"

    def _relate_axes(self) -> None:
        """Raise ScenarioError for separate bounds of the axes if wheels are limited, which move
        both.
        """
        apart = [name for name in BY_AXIS if is_by_axis(getattr(self, name))]
        apart += ["loop"] * (self.loop[0] != self.loop[1])
        wheels = "channels" if self.channels == "wheels" else "wheel_speed" * bool(self.wheel_speed)
        if apart and wheels:
            raise ScenarioError(
                f"filter.{apart[0]} is stated for v and omega each, and filter.{wheels} limits "
                "wheels, whose speeds are sums of both and whose loops have to be alike. State one "
                f"for both axes, or leave out filter.{wheels}."
            )

    def _relate_told(self) -> None:
        """Raise ScenarioError if the filter cannot use limits or distances received during a
        run.
        """
        told = {"changing": self.changing, "free_error": self.free_error is not None}
        name = next((key for key, is_told in told.items() if is_told), "rest")
        kinds = ("governor",) if name == "rest" else ("governor", "clip")
        if self.kind not in kinds:
            raise ScenarioError(
                f'filter.{name} does not go with filter.kind = "{self.kind}", which bounds no '
                f"stopping distance. Use filter.kind = {quoted(kinds)}, or leave it out."
            )
        wheels = "channels" if self.channels == "wheels" else "wheel_speed" * bool(self.wheel_speed)
        if wheels or self.slew is not None:
            raise ScenarioError(
                f"filter.{name} concerns v and omega, each by itself and at once. Leave out "
                f"filter.{wheels or 'slew'}."
            )
        if self.free_error is None:
            if self.nearing:
                raise ScenarioError(
                    "filter.nearing is about obstacles, and no distance is told. State "
                    "filter.free_error, or leave out filter.nearing."
                )
            return
        if self.kind == "clip":
            self._relate_ramps()
        if self.rest is None and (any(self.d) or self.nearing):
            cause = (
                f"filter.nearing = {self.nearing:g} m/s: an obstacle approaches for ever"
                if self.nearing
                else f"filter.d = [{self.d[0]:g}, {self.d[1]:g}]: a push moves the base for ever"
            )
            raise ScenarioError(
                f"filter.rest is missing, and {cause}, so that no stop ends in time. State how "
                "long after commands of 0 the base stands and holds: its brake, its time-out or "
                "its control at standstill."
            )
        linear, angular = self.intervals("delay")
        if linear != angular:
            raise ScenarioError(
                "filter.delay differs for v and omega: the stop of one axis would end before that "
                "of the other. With filter.free_error state one interval that holds for both."
            )
        if self.nearing and self.leave:
            raise ScenarioError(
                "filter.leave keeps a distance for releases, which an approaching obstacle "
                "(filter.nearing) uses up while the base rests. Set filter.leave = 0: the base "
                "then moves away where its distance certifies that."
            )

    def _relate_ramps(self) -> None:
        """Raise ScenarioError if a clip cannot stop in time."""
        if self.decel is None:
            raise ScenarioError(
                'filter.decel is missing: filter.kind = "clip" with filter.free_error stops in '
                "time on a base that slows down by at least so much. Give decel = [m/s2, rad/s2], "
                'or use filter.kind = "governor".'
            )
        if self.loop != FIRST_ORDER or self.odometry is None:
            raise ScenarioError(
                "filter.decel is for a base that never passes its command, and whose odometry is "
                'used: state filter.odometry, and filter.loop = "first-order".'
            )

    def _relate_loop(self, axis: int) -> None:
        """Raise ScenarioError if a loop lacks its numbers, or the filter does not suit it."""
        loop = self.loop[axis]
        needed = {"second-order": ("damping",), "pi": (("mass", "inertia")[axis], "kp", "ki")}
        for name in needed.get(loop, ()):
            if getattr(self, name) is None:
                raise ScenarioError(
                    f'filter.{name} is missing: filter.loop = "{loop}" relies on its bounds. '
                    f"Give {name} = [low, high]."
                )
        if loop != "first-order" and self.kind == "governor":
            raise ScenarioError(
                f'filter.kind = "governor" does not hold for filter.loop = "{loop}": it '
                "relies on a speed that responds at once, which a loop with an internal state does "
                'not. Set filter.kind = "clip" or "band".'
            )
        if loop == "pi" and self.intervals("gain")[axis] != (1.0, 1.0):
            raise ScenarioError(
                'filter.loop = "pi" reaches its command at rest: state filter.gain = [1, 1], the '
                "largest push as push = [N, N.m], and as filter.d the largest error of the command "
                "that acts, such as half a quantum."
            )
        if loop == "pi" and (self.channels == "wheels" or self.wheel_speed):
            raise ScenarioError(
                'filter.loop = "pi" has different masses for v and omega, so that a wheel\'s '
                "speed does not depend on that wheel's command alone: leave out filter.channels "
                "and filter.wheel_speed."
            )

    def _relate_slew(self) -> None:
        """Raise ScenarioError if a limit on the rate of commands has no use."""
        if self.kind != "clip" or "first-order" in self.loop:
            raise ScenarioError(
                'filter.slew is for filter.kind = "clip" with loops that overshoot: they do so '
                "less if commands change slowly. Other filters do not need it. Leave it out."
            )
        if "second-order" in self.loop and self.frequency is None:
            raise ScenarioError(
                "filter.frequency is missing: with filter.slew the clip relies on how fast the "
                "loop is. Give frequency = [low, high] [rad/s], or leave out filter.slew."
            )
        if self.hold > 0 or self.channels == "wheels" or self.wheel_speed:
            raise ScenarioError(
                "filter.slew limits how fast v and omega change. It covers neither a base that "
                "stops on its own nor single wheels: leave out filter.hold, filter.channels and "
                "filter.wheel_speed."
            )

    def _relate_band(self) -> None:
        """Raise ScenarioError for options that the band does not support."""
        if "first-order" in self.loop:
            raise ScenarioError(
                'filter.kind = "band" is for loops that overshoot: state filter.loop = "pi" or '
                '"second-order" with its numbers, or use filter.kind = "governor".'
            )
        if "second-order" in self.loop and self.frequency is None:
            raise ScenarioError(
                "filter.frequency is missing: the band relies on bounds of the natural frequency. "
                'Give frequency = [low, high] [rad/s], or use filter.kind = "clip".'
            )
        spread = max(high - low for low, high in self.intervals("delay"))
        late = {"losses": self.losses, "hold": self.hold, "delay": spread}
        for name, size in late.items():
            if size > 0:
                raise ScenarioError(
                    f'filter.{name}: filter.kind = "band" relies on each command taking effect, a '
                    "constant delay after it was sent. Use "
                    'filter.kind = "clip", which holds for losses, hold and varying delays.'
                )
        if self.odometry is not None or self.channels == "wheels" or self.wheel_speed:
            raise ScenarioError(
                'filter.kind = "band" limits v and omega from its own commands: leave out '
                "filter.odometry, filter.channels and filter.wheel_speed. A preset that states "
                "them cannot be extended: begin with a copy (wmr-ctrl scenarios NAME --toml)."
            )
