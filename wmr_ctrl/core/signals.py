"""Signal: name, unit, size and meaning of one quantity, and the catalogue that fixes every order.

Everything that is ordered follows this page: vectors in CasADi graphs, enums in C, variables of
FMUs, columns of results, labels of plots.  It imports nothing of the package, so that every
layer may use it.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import accumulate, pairwise


@dataclass(frozen=True)
class Signal:
    """One named quantity: a scalar (size 1) or a vector of ``size`` elements in one unit list.

    ``unit`` is one SI unit, or one per element with commas between where they differ
    (``"m/s, rad/s"``).  Indices in names and messages count from 1.
    """

    name: str
    unit: str
    meaning: str
    size: int = 1

    @property
    def elements(self) -> tuple[str, ...]:
        """Names of the elements: the name itself, or ``name[1]`` to ``name[size]``."""
        if self.size == 1:
            return (self.name,)
        return tuple(f"{self.name}[{i}]" for i in range(1, self.size + 1))

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each element."""
        parts = tuple(part.strip() for part in self.unit.split(","))
        return parts if len(parts) == self.size else parts[:1] * self.size


def places(signals: Iterable[Signal]) -> dict[str, slice]:
    """Slices of signals that follow each other in one vector, by name."""
    listed = tuple(signals)
    ends = pairwise(accumulate((item.size for item in listed), initial=0))
    return {item.name: slice(*pair) for item, pair in zip(listed, ends, strict=True)}


def elements(signals: Iterable[Signal]) -> tuple[str, ...]:
    """Names of all elements of some signals, in order."""
    return tuple(name for signal in signals for name in signal.elements)


LARGEST = 1e12
"""Largest size of any input or parameter, in the SI unit of each: up to here every law's
force and memory stay finite.  Stands for `unlimited` too."""
TIME = Signal("t", "s", "time")

PLANT_STATE = (
    Signal("x", "m", "position of the axle's midpoint along X"),
    Signal("y", "m", "position of the axle's midpoint along Y"),
    Signal("theta", "rad", "orientation, 0 along +Y, forward = (-sin theta, cos theta)"),
    Signal("v1", "m/s", "linear velocity"),
    Signal("omega", "rad/s", "angular velocity (v2 in the paper)"),
)
POSE = PLANT_STATE[:3]
VELOCITY = PLANT_STATE[3:]
PSI = Signal("psi", "rad", "usual heading, psi = theta + pi/2")

MEASURED_POSE = (
    Signal("x_measured", "m", "measured position along X"),
    Signal("y_measured", "m", "measured position along Y"),
    Signal("theta_measured", "rad", "measured orientation"),
)
MEASURED_VELOCITY = (
    Signal("v1_measured", "m/s", "measured linear velocity"),
    Signal("omega_measured", "rad/s", "measured angular velocity"),
)
"""Inputs of a law in the place of pose and velocity."""
MEASURED = (*MEASURED_POSE, *MEASURED_VELOCITY)
ODOMETRY_AGE = Signal("odometry_age", "s", "age of the odometry; negative: there is none")
SAMPLE = Signal("sample", "1", "number of the control sample, from 0")
STEP = Signal("step", "1", "number of the plant step, from 0")
TRAVEL = Signal("travel", "m, rad", "way and turn since the previous sample", 2)
PATH = Signal("path", "m", "way since the start, backwards counted negative")
SKID = Signal("skid", "rad", "turn since the start by the wheels' rolling, less the body's")
"""Zero on a plant whose wheels only roll."""
REFERENCE = (
    Signal("x_d", "m", "desired position along X"),
    Signal("y_d", "m", "desired position along Y"),
    Signal("theta_d", "rad", "desired orientation, continuous in time"),
    Signal("v1_d", "m/s", "desired linear velocity"),
    Signal("v2_d", "rad/s", "desired angular velocity"),
    Signal("v1_d_dot", "m/s2", "rate of the desired linear velocity"),
    Signal("v2_d_dot", "rad/s2", "rate of the desired angular velocity"),
)

TORQUE = (
    Signal("tau_right", "N.m", "torque on the right wheel, as commanded"),
    Signal("tau_left", "N.m", "torque on the left wheel, as commanded"),
)
TORQUE_NOISE = (
    Signal("noise_right", "N.m", "disturbance torque on the right wheel"),
    Signal("noise_left", "N.m", "disturbance torque on the left wheel"),
)
BODY_FORCE = (
    Signal("thrust", "N", "disturbance force on the body along its heading"),
    Signal("moment", "N.m", "disturbance moment on the body"),
)
DISTURBING = (*TORQUE_NOISE, *BODY_FORCE)
COMMAND = (
    Signal("v_command", "m/s", "commanded linear velocity, as sent to the base"),
    Signal("omega_command", "rad/s", "commanded angular velocity, as sent to the base"),
)
"""Inputs of a base that takes velocities."""
ASKED = Signal("v_asked", "m/s, rad/s", "commanded velocity (linear, angular), unfiltered", 2)
SENT_BEFORE = Signal(
    "v_sent_before", "m/s, rad/s", "velocity sent at the previous sample, behind the filter", 2
)
TAU_APPLIED = Signal(
    "tau_applied", "N.m", "torque applied over the previous sample (right, left)", 2
)


def tau_sent(age: int) -> Signal:
    """The torque commanded ``age`` samples ago, after the wheels' limit."""
    return Signal(f"tau_sent{age}", "N.m", f"torque commanded {age} samples ago", 2)


FORCE = Signal("force", "N, N.m", "force that a law asks for (thrust, turning moment)", 2)

TRACKING_ERROR = Signal("e", "m, m, rad", "tracking error, Eq. (8): ahead, to the left, angle", 3)
DIAGNOSTICS = (
    Signal("v_c0", "m/s, rad/s", "auxiliary velocity, Eq. (7)", 2),
    Signal("v_c1", "m/s, rad/s", "minimiser of the barrier function, Eq. (18)", 2),
    Signal("V1", "1", "barrier Lyapunov function, Eq. (12)"),
    Signal("q", "1", "(v - v_c1)/A, in (0, 1]", 2),
    Signal(
        "margin", "1", "distance to the velocity limit as measured, min over axes of 1 - |v|/v_u1"
    ),
)
GUARD_DIAGNOSTICS = (
    Signal("clip_active", "1", "1 where the guard changed the force, else 0", 2),
    Signal(
        "d_least", "N, N.m", "smallest disturbance that can explain the previous sample's motion", 2
    ),
    Signal("feasible", "1", "1 where the guard's bounds leave a safe force at every state, else 0"),
)
"""Diagnostics of a guarded controller beside its law's."""
GUARD_ACTED = Signal("guard_acted", "1", "1 where the guard or filter acted, else 0")
REFUSED = Signal("refused", "1", "1 where an input was refused, else 0")
D_HAT = Signal("d_hat", "N, N.m", "disturbance as the observer estimates it", 2)

WHEEL_SPEED = Signal("wheel_speed", "rad/s", "speed of the wheels (right, left)", 2)
SLIP = Signal("slip", "m/s", "tread over ground (right, left), positive on a wheel that spins", 2)
TILT = Signal("tilt", "rad", "angle between the robot's axis and the ground's normal")
TIP_MARGIN = Signal(
    "tip_margin", "1", "distance of the load's centre from the edge of the support, 1 over the axle"
)
RIGID = (WHEEL_SPEED, SLIP, TILT, TIP_MARGIN)
"""Columns of a rigid body's log after those that every plant has."""
MOTION = (TIME, *PLANT_STATE, PSI, *REFERENCE)
LOG_HEAD = (*MOTION, *TORQUE, *TORQUE_NOISE, TRACKING_ERROR, *DIAGNOSTICS)
"""The columns that every logged run has, in order; a law's own diagnostics follow."""
