"""Signal: name, unit, size and meaning of one quantity, and the catalogue that fixes every order.

Everything that is ordered follows signals.toml: vectors in CasADi graphs, enums in C, variables of
FMUs, columns of results, labels of plots.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import accumulate, pairwise

from .data import data


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


_GROUPS = {
    group: tuple(Signal(name, *row) for name, row in rows.items())
    for group, rows in data(__package__, "signals.toml").items()
}
_SINGLE = {signal.name: signal for signal in _GROUPS["single"]}
LARGEST = 1e12
"""Largest size of any input or parameter, in the SI unit of each: up to here every law's
force and memory stay finite.  Stands for `unlimited` too."""
TIME = _SINGLE["t"]

PLANT_STATE = _GROUPS["plant_state"]
POSE = PLANT_STATE[:3]
VELOCITY = PLANT_STATE[3:]
PSI = _SINGLE["psi"]

MEASURED_POSE = _GROUPS["measured_pose"]
MEASURED_VELOCITY = _GROUPS["measured_velocity"]
"""Inputs of a law in the place of pose and velocity."""
MEASURED = (*MEASURED_POSE, *MEASURED_VELOCITY)
ODOMETRY_AGE = _SINGLE["odometry_age"]
SAMPLE = _SINGLE["sample"]
STEP = _SINGLE["step"]
TRAVEL = _SINGLE["travel"]
PATH = _SINGLE["path"]
SKID = _SINGLE["skid"]
"""Zero on a plant whose wheels only roll."""
REFERENCE = _GROUPS["reference"]

TORQUE = _GROUPS["torque"]
TORQUE_NOISE = _GROUPS["torque_noise"]
BODY_FORCE = _GROUPS["body_force"]
DISTURBING = (*TORQUE_NOISE, *BODY_FORCE)
COMMAND = _GROUPS["command"]
"""Inputs of a base that takes velocities."""
ASKED = _SINGLE["v_asked"]
SENT_BEFORE = _SINGLE["v_sent_before"]
TAU_APPLIED = _SINGLE["tau_applied"]


def tau_sent(age: int) -> Signal:
    """The torque commanded ``age`` samples ago, after the wheels' limit."""
    return Signal(f"tau_sent{age}", "N.m", f"torque commanded {age} samples ago", 2)


FORCE = _SINGLE["force"]

TRACKING_ERROR = _SINGLE["e"]
DIAGNOSTICS = _GROUPS["diagnostics"]
GUARD_DIAGNOSTICS = _GROUPS["guard_diagnostics"]
"""Diagnostics of a guarded controller beside its law's."""
GUARD_ACTED = _SINGLE["guard_acted"]
REFUSED = _SINGLE["refused"]
D_HAT = _SINGLE["d_hat"]

WHEEL_SPEED = _SINGLE["wheel_speed"]
SLIP = _SINGLE["slip"]
TILT = _SINGLE["tilt"]
TIP_MARGIN = _SINGLE["tip_margin"]
RIGID = (WHEEL_SPEED, SLIP, TILT, TIP_MARGIN)
"""Columns of a rigid body's log after those that every plant has."""
MOTION = (TIME, *PLANT_STATE, PSI, *REFERENCE)
LOG_HEAD = (*MOTION, *TORQUE, *TORQUE_NOISE, TRACKING_ERROR, *DIAGNOSTICS)
"""The columns that every logged run has, in order; a law's own diagnostics follow."""
