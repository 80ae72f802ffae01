"""Tables of a scenario that belong to no effect and no reference, a Section each."""

import math
from collections.abc import Mapping, Sequence

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.section import REQUIRED, Section, quantity
from wmr_ctrl.core.fields.units import plain
from wmr_ctrl.core.fields.unstated import Unknown, Unstated, derived, unknown
from wmr_ctrl.core.fields.values import Pair, check_multiple, is_by_axis
from wmr_ctrl.results.obstacles import Shape

CHANGING = {"m": "kg", "I": "kg m2", "mu": ""}
"""Fields of the robot that may change during a run, with their units in words."""
MOST_SAMPLES, MOST_SUBSTEPS = 10_000_000, 100_000
BARRIER_FROM = 0.85
"""Share of a limit from which the barrier acts where nobody states it."""
REST = 2.0
"""Seconds at the goal of a run whose duration nobody states."""
ENDLESS = 60.0
"""Duration [s] of a run whose desired motion never comes to rest."""


class Robot(Section, key="robot"):
    """Parameters of the plant, Eqs. (1)-(6): a two-wheeled robot with its mass on the axle.

    A base that takes torques needs m, I, mu, r and l. One that takes velocities needs those that
    another part reads; the others may be placeholders, on which no motion depends.
    """

    m: float = quantity(unknown(1.0), "kg", "mass", above=0, usual=(0.02, 5000))
    I: float = quantity(unknown(1.0), "kg.m2", "moment of inertia about the vertical", above=0)
    mu: float = quantity(
        unknown(0.0), "1", "coefficient of Coulomb friction", minimum=0, usual=(0, 1)
    )
    r: float = quantity(
        unknown(1.0), "m", "radius of the driving wheels", above=0, usual=(0.003, 1)
    )
    l: float = quantity(
        unknown(1.0), "m", "half the track: axle's midpoint to wheel", above=0, usual=(0.005, 3)
    )
    g: float = quantity(9.81, "m/s2", "gravity", above=0)
    v_s: float = quantity(0.01, "m/s", "speed that smooths friction, mu m g tanh(v1/v_s)", above=0)


class Model(Section, key="model"):
    """Model of the laws; a field that is left out is the robot's, before any change."""

    m: float | None = quantity(None, "kg", "mass that the laws assume; default: robot.m", above=0)
    I: float | None = quantity(
        None, "kg.m2", "inertia that the laws assume; default: robot.I", above=0
    )
    mu: float | None = quantity(
        None, "1", "friction that the laws assume; default: robot.mu", minimum=0
    )


class Body(Section, key="body"):
    """Rigid-body parameters in addition to mass, inertia, friction, wheels and track of [robot].

    The plane model does not read it.  Casters slide without friction.  Omitted values are in
    proportion to the robot: height 1.2 r, caster 1.2 l, wheel_width 0.4 r, wheel_mass 0.03 m.
    """

    tyre: float = quantity(0.8, "1", "friction between tyre and ground", above=0)
    grip: float = quantity(0.02, "s", "time in which a sliding tread is stopped", minimum=0.005)
    height: float = quantity(unknown(1.2), "m", "centre of mass above the ground", above=0)
    caster: float = quantity(unknown(1.2), "m", "axle to the casters in front and behind", above=0)
    caster_gap: float = quantity(5e-4, "m", "casters above the ground", minimum=0)
    flatness: float = quantity(
        0.55, "1", "ratio of the inertia in pitch and roll to that in yaw", minimum=0.5
    )
    wheel: str = quantity(
        "sphere", "1", "tyre: point contact, or line contact that scrubs in turns",
        options=("sphere", "cylinder"),
    )  # fmt: skip
    wheel_width: float = quantity(unknown(0.4), "m", "width of a cylinder's tread", above=0)
    radius: float | None = quantity(
        None, "m", "distance from the axle's midpoint to the body's farthest point, for keep_out",
        above=0,
    )  # fmt: skip
    wheel_mass: float = quantity(
        unknown(0.03), "kg", "mass of each wheel, part of robot.m", above=0
    )
    slope: float = quantity(
        0.0, "rad", "rise of the ground; the plane model has slope.angle", minimum=0,
        maximum=math.pi / 4,
    )  # fmt: skip
    uphill: float = quantity(0.0, "rad", "uphill direction, 0 along +Y", orientation=1)
    slip_max: float = quantity(
        0.1, "m/s", "speed of the tread over the ground above which the robot has slipped", above=0
    )
    tilt_max: float = quantity(
        0.5, "rad", "tilt of the axis above which the robot has tipped", above=0,
        maximum=math.pi / 2,
    )  # fmt: skip


class World(Section, key="world"):
    """Obstacles around the robot, which a filter with `free_error` sees without error."""

    obstacles: tuple[Shape, ...] = quantity(
        (), "m", "circles [x, y, r], polygons [[x, y], ...]", kind="shapes"
    )
    wall: tuple[Pair, ...] = quantity((), "m", "both ends of a wall", kind="points")

    def relate(self) -> None:
        """Check that a wall has two ends."""
        if self.wall and (len(self.wall) != 2 or self.wall[0] == self.wall[1]):
            raise ScenarioError(
                f"world.wall has {len(set(self.wall))} ends and must have two, as in "
                "[[3, -2], [3, 2]]. State longer outlines as polygons in world.obstacles."
            )

    @property
    def shapes(self) -> tuple[Shape, ...]:
        """All obstacles of this table."""
        return (*self.obstacles, *((self.wall,) if self.wall else ()))


class Ros(Section, key="ros"):
    """Default names for the ROS 2 nodes, if no parameter states them."""

    base_frame: str = quantity(
        "base_link", "1", "frame of commands and child frame of odometry; empty: any"
    )


class Limits(Section, key="limits"):
    """Velocity limits v_u1 and barrier thresholds v_u2 (linear, angular), Eqs. (10)-(20).

    ``v_min`` and ``v_max`` limit the two directions separately, within v_u1, which is the scale for
    laws.  An omitted v_u1 is the larger of both.
    """

    v_u1: Pair = quantity(unknown((1.0, 1.0)), "m/s, rad/s", "limits of |v1| and |omega|", above=0)
    v_min: Pair = quantity(
        derived((-1.0, -1.0)), "m/s, rad/s",
        "least v1 and omega, so that it may stop; 0: none backwards; default: -v_u1", maximum=0,
    )  # fmt: skip
    v_max: Pair = quantity(
        derived((1.0, 1.0)), "m/s, rad/s", "largest v1 and omega; default: v_u1", minimum=0
    )
    v_u2: Pair = quantity(
        derived((0.85, 0.85)),
        "m/s, rad/s",
        "thresholds above which the barrier acts; default: 0.85 v_u1",
        above=0,
    )
    clip: float = quantity(
        1e-6, "m/s, rad/s", "barrier terms see |v| clipped to v_u1 - clip", above=0
    )

    def relate(self) -> None:
        """Each axis needs -v_u1 <= v_min <= 0 <= v_max <= v_u1, v_u2 < v_u1, clip < v_u1 - v_u2."""
        self._relate_sides()
        if isinstance(self.v_u2, Unstated):
            follows = derived(BARRIER_FROM * limit for limit in self.v_u1)
            object.__setattr__(self, "v_u2", follows)
        if isinstance(self.v_u1, Unknown):
            return  # said where it is asked for
        rows = zip(self.v_u1, self.v_u2, ("m/s", "rad/s"), strict=True)
        for axis, (high, low, unit) in enumerate(rows, 1):
            if not low < high:
                raise ScenarioError(
                    f"limits.v_u2[{axis}] = {low!r} must be below limits.v_u1[{axis}] = {high!r} "
                    f"{unit}: the barrier acts between the two. Lower v_u2 or raise v_u1."
                )
            if not self.clip < high - low:
                raise ScenarioError(
                    f"limits.clip = {self.clip!r} must be below v_u1[{axis}] - v_u2[{axis}] = "
                    f"{high - low:g} {unit}, or the barrier never acts. The default is 1e-06."
                )

    @property
    def apart(self) -> bool:
        """True if a direction has its own limit."""
        return not (isinstance(self.v_min, Unstated) and isinstance(self.v_max, Unstated))

    @property
    def sides(self) -> tuple[Pair, Pair]:
        """Least and largest v1 [m/s], and omega [rad/s]."""
        return (self.v_min[0], self.v_max[0]), (self.v_min[1], self.v_max[1])

    @property
    def unequal(self) -> tuple[int, ...]:
        """Axes, from 0, whose two directions have different limits."""
        return tuple(i for i in (0, 1) if self.v_max[i] != -self.v_min[i])

    @property
    def smaller(self) -> Pair:
        """For each axis the smaller of both directions' limits."""
        v, omega = (min(-self.v_min[i], self.v_max[i]) for i in (0, 1))
        return v, omega

    def narrow(self, axis: int) -> tuple[str, float]:
        """Key and value of the smaller limit of an axis; axes count from 0."""
        return self.side(axis, 1 if self.smaller[axis] == self.v_max[axis] else -1)

    def side(self, axis: int, way: float) -> tuple[str, float]:
        """Key and value of the limit of a velocity of this sign."""
        if not self.apart:
            return f"limits.v_u1[{axis + 1}]", self.v_u1[axis]
        name, pair = ("v_max", self.v_max) if way > 0 else ("v_min", self.v_min)
        return f"limits.{name}[{axis + 1}]", pair[axis]

    def excess(self, v: Sequence[float]) -> Pair:
        """How far velocities are beyond the limit of their direction; negative within."""
        linear, angular = (max(v[i] - self.v_max[i], self.v_min[i] - v[i]) for i in (0, 1))
        return linear, angular

    def _relate_sides(self) -> None:
        """Derive the unstated ones of v_u1, v_min and v_max; ScenarioError for impossible ones."""
        stated = [side for side in (self.v_min, self.v_max) if not isinstance(side, Unstated)]
        if isinstance(self.v_u1, Unstated) and stated:
            larger = derived(max(map(abs, pair)) for pair in zip(*stated, strict=True))
            object.__setattr__(self, "v_u1", larger)
        if isinstance(self.v_min, Unstated):
            object.__setattr__(self, "v_min", derived(-limit for limit in self.v_u1))
        if isinstance(self.v_max, Unstated):
            object.__setattr__(self, "v_max", derived(self.v_u1))
        rows = zip(self.v_min, self.v_max, self.v_u1, ("m/s", "rad/s"), strict=True)
        for axis, (low, high, most, unit) in enumerate(rows, 1):
            for name, value in (("v_min", low), ("v_max", high)):
                if abs(value) > most:
                    raise ScenarioError(
                        f"limits.{name}[{axis}] = {value!r} {unit} is beyond limits.v_u1[{axis}] = "
                        f"{most!r}, which holds both ways. Lower it, raise v_u1, or leave v_u1 "
                        "out: it is then the larger of v_max and -v_min."
                    )
            if low == high == 0:
                raise ScenarioError(
                    f"limits.v_min[{axis}] and limits.v_max[{axis}] are both 0 {unit}: that axis "
                    "could not move. State a larger v_max or a smaller v_min."
                )


class Initial(Section, key="initial"):
    """Pose and velocity at t = 0; the velocity may lie outside the limits.

    Omitted values are the desired motion's at t = 0; with a guard and late velocities the robot
    then starts at rest.
    """

    pose: tuple[float, float, float] = quantity(
        derived((0.0, 0.0, 0.0)), "m, m, rad", "x, y, theta (theta is 0 along +Y)", orientation=3
    )
    velocity: Pair = quantity(derived((0.0, 0.0)), "m/s, rad/s", "v1, omega")


class Clock(Section, key="clock"):
    """Control period (zero-order hold), plant step (RK4) and duration of a run.

    Without a duration a run ends 2 s after the desired motion comes to rest, or after 60 s if it
    never does.
    """

    control: float = quantity(0.01, "s", "period of the control law", minimum=1e-9, usual=(1e-4, 1))
    plant: float = quantity(
        0.001, "s", "step of the plant's integration", minimum=1e-9, usual=(1e-6, 0.1)
    )
    duration: float = quantity(derived(ENDLESS), "s", "length of a run", minimum=1e-9)

    @property
    def substeps(self) -> int:
        """Plant steps in one control period."""
        return round(self.control / self.plant)

    def beyond(self, arrival: float) -> float:
        """Duration [s] that shows whether the robot stays at a goal reached at ``arrival`` [s]."""
        return self.covering(arrival + max(REST, self.control))

    def covering(self, time: float) -> float:
        """Shortest duration [s] of whole control periods that is not below a ``time`` [s]."""
        return derived(self.control * max(1, math.ceil(time / self.control - 1e-9)))

    @property
    def samples(self) -> int:
        """Control periods in a run."""
        return round(self.duration / self.control)

    def relate(self) -> None:
        """Check that the control period is whole plant steps, and the run whole control periods."""
        if isinstance(self.duration, Unstated):
            object.__setattr__(self, "duration", self.covering(self.duration))
        period, last = self.control, self.duration
        check_multiple("clock.control", period, "clock.plant", self.plant, MOST_SUBSTEPS, 1)
        check_multiple("clock.duration", last, "clock.control", period, MOST_SAMPLES, 1)


class Metrics(Section, key="metrics"):
    """Split of a run into before and after, start of the torque's RMS, tolerance of tracking.

    The default tolerance suits a doorway: 0.2 robot.l or, if robot.l is unstated, the distance
    driven in 0.05 s at limits.v_u1.
    """

    split: float | None = quantity(
        None, "s", "time that separates before and after; default: half the duration", above=0
    )
    rms_from: float = quantity(2.0, "s", "start of the torque's RMS", minimum=0)
    tolerance: float = quantity(
        derived(0.05), "m",
        "largest RMS position error, in the drive and at the end, that counts as tracked", above=0,
    )  # fmt: skip


class CorridorSettings(Section, key="corridor"):
    """Settings of the certified corridor, which no run reads."""

    start: tuple[float, float, float] = quantity(
        (0.0, 0.0, 0.0), "m, m, rad", "largest initial error e", minimum=0
    )
    cells: int = quantity(
        0, "1",
        "parts of the guard's intervals of mass and of inertia, one certificate for each pair; "
        "0: robot.m and robot.I alone",
        minimum=0, maximum=32,
    )  # fmt: skip
    losses: int = quantity(
        0, "1",
        "poses lost in a row at most, where sensor.pose_dropout loses some by chance; 0: not said",
        minimum=0, maximum=1000,
    )  # fmt: skip


def robot_number(name: str, value: float) -> str:
    """Mass, inertia or friction of a robot with its unit, such as "65 kg"."""
    return f"{plain(value)} {CHANGING[name]}".strip()


class Change(Section, key="changes"):
    """New parameters from the first plant step that starts at or after ``t``; others stay."""

    t: float = quantity(REQUIRED, "s", "time of the change", minimum=0)
    m: float | None = quantity(None, "kg", "mass from then on", above=0)
    I: float | None = quantity(None, "kg.m2", "inertia from then on", above=0)
    mu: float | None = quantity(None, "1", "friction from then on", minimum=0)

    def values(self) -> dict[str, float]:
        """New values by the robot's field."""
        given = {"m": self.m, "I": self.I, "mu": self.mu}
        return {key: value for key, value in given.items() if value is not None}

    @property
    def sentence(self) -> str:
        """Sentence on the robot's new numbers."""
        words = {
            "m": "weighs",
            "I": "has an inertia of",
            "mu": "has a friction coefficient of",
        }
        given = self.values().items()
        *others, last = (f"{words[key]} {robot_number(key, value)}" for key, value in given)
        listed = f"{', '.join(others)} and {last}" if others else last
        return f"From {plain(self.t)} s on the robot {listed}."


class Guard(Section, key="guard"):
    """Settings of the guard that keeps |v1|, |omega| within limits.v_u1 (linear, angular).

    Omitted values are derived from the rest of the scenario: masses from the laws' model of the
    robot, dbar from the noise, nbar from the sensor, delay and lag from the drives, alpha from the
    control period, brake from the torque limit.  Building the guard checks whether the settings can
    be met.  A stated bound that the scenario itself breaks is refused there, unless ``trust``
    permits it.  A robot that differs from the believed one is run, without promise.
    """

    enabled: bool = quantity(False, "1", "switch the guard on")
    trust: bool = quantity(False, "1", "accept stated bounds although the scenario breaks them")
    map: str = quantity(
        "linear-first", "1", "axis that gets the wheel torques first",
        options=("linear-first", "rotation-first"),
    )  # fmt: skip
    mass_margin: float = quantity(
        0.1, "1", "share by which M_min and M_max extend beyond the model's mass", minimum=0,
        below=1,
    )  # fmt: skip
    M_min: Pair | None = quantity(
        None, "kg, kg.m2", "smallest possible mass and inertia", above=0, size=2
    )
    M_max: Pair | None = quantity(
        None, "kg, kg.m2", "largest possible mass and inertia", above=0, size=2
    )
    dbar: Pair | None = quantity(
        None, "N, N.m", "bound of the disturbance force", minimum=0, size=2
    )
    d_model: Pair = quantity(
        (0.0, 0.0), "N, N.m", "added to a dbar that is derived from the noise", minimum=0
    )
    nbar: Pair | None = quantity(
        None, "m/s, rad/s", "bound of the velocity's error", minimum=0, size=2
    )
    delay: Pair | None = quantity(
        None, "s", "bounds of a command's delay, which may vary", minimum=0, maximum=10, size=2,
        usual=(0, 2),
    )  # fmt: skip
    lag: Pair | None = quantity(
        None, "s", "bounds of the drives' time constant, which may vary; equal bounds: constant",
        minimum=0, size=2, usual=(0, 2),
    )  # fmt: skip
    alpha: float | None = quantity(
        None, "1/s", "fastest rate of approach to the limit, at most 1/T", above=0
    )
    brake: Pair | None = quantity(
        None, "N, N.m", "largest force with which the guard brakes", minimum=0, size=2
    )
    brake_share: float = quantity(
        0.5, "1", "share of spare wheel torque for linear braking", minimum=0, maximum=1
    )
    f_min: Pair = quantity(
        (0.0, 0.0), "N, N.m", "friction that certainly acts above f_speed", minimum=0
    )
    f_speed: Pair = quantity((0.0, 0.0), "m/s, rad/s", "speed above which f_min acts", minimum=0)
    changing: bool = quantity(
        False, "1", "each sample is told the limits in force; those of [limits] are the widest"
    )
    falling: Pair | None = quantity(
        None, "m/s2, rad/s2", "fastest fall of a limit; default: the fastest that is kept",
        above=0, size=2,
    )  # fmt: skip

    def masses(self, m: float, inertia: float) -> tuple[Pair, Pair]:
        """Smallest, largest mass and inertia [kg, kg m2]: stated, or from a model by
        mass_margin.
        """
        low, high = 1.0 - self.mass_margin, 1.0 + self.mass_margin
        return self.M_min or (low * m, low * inertia), self.M_max or (high * m, high * inertia)

    def relate(self) -> None:
        """Check the order of bounds: M_min <= M_max if both are stated, and those of delay and
        lag.
        """
        check_intervals(self, {"delay": "a command's delay", "lag": "the time constant"})
        pairs = zip(self.M_min or (), self.M_max or (), strict=False)
        for axis, (low, high) in enumerate(pairs, 1):
            if low > high:
                raise ScenarioError(
                    f"guard.M_min[{axis}] = {low!r} must be at most guard.M_max[{axis}] = "
                    f"{high!r}: they bound the same mass. Give both, or leave both out."
                )


def check_intervals(section: Section, names: Mapping[str, str]) -> None:
    """Raise ScenarioError if an interval is reversed; ``names``: quantity in each interval."""
    for name, what in names.items():
        value = getattr(section, name)
        rows = value if is_by_axis(value) else () if value is None else (value,)
        for first, second in rows:
            if first > second:
                raise ScenarioError(
                    f"{section.KEY}.{name} = [{first!r}, {second!r}] is the wrong way round: "
                    f"{what} lies between the first and the second. Write [{second!r}, {first!r}]."
                )
