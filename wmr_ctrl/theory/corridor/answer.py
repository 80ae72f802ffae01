"""Corridor: the largest distance of a law's robot from its path, as values and as text.

It is computed by `wmr_proofs.corridor.masses`, which needs python-flint.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field

from wmr_ctrl.core.fields.units import length, rounded
from wmr_ctrl.theory.checks.error_coordinates import Floats
from wmr_ctrl.theory.checks.unknown_zero import COARSE

from .clearance import Clearance

ALONE = "around that mass alone (others were not tried) it"
"""Scope of a smaller corridor that is named where cells of masses are refused."""


@dataclass(frozen=True)
class Corridor:
    """Certified distance of a law's robot from its path, or why there is none.

    ``position`` [m] and ``heading`` [rad]: the largest deviation from the path at plant steps, if
    the robot starts on it.  ``linear`` [m]: the position deviation of a linear loop, which a push
    attains; None without such a loop.  ``binding``: name of the limit that comes nearest to acting
    (the wheels' limit, the guard, a limit of the law); ``share``: how near.

    ``push``: largest torque on each wheel [N m], held over a sample; ``pose``: largest error of the
    measured position [m]; ``velocity``: that of each measured velocity; ``mass`` [kg].  ``until``
    [s]: the robot's first change, None without one.

    ``refused``: why there is no corridor.  ``closes``: factor on push and errors for which there is
    one; ``near``: the same factor on ``start``; None if none was found.  ``alone``: these were
    tried only for the refused cell of masses.  ``masses``: intervals of mass and inertia [kg, kg
    m2], None for ``mass`` alone.  ``start``: initial bounds of e [m, m, rad].  ``position_late``
    [m]: the position deviation in the long run.  ``late``: initial contents of drives or of the
    base's own loop, as text; empty if none.  ``missing``: largest number of consecutive samples
    without a pose.  ``anew``: mass or inertia may change from any of these values to any other.
    ``run`` [s]: duration of the run that the corridor is valid for, with all changes in it;
    otherwise it is valid for ever.  ``whole``: the corridor of the whole run, if it was requested
    and this one ends at a change of the robot or excludes initial contents of drives.
    ``clearance``: distance left to the scenario's obstacles, None without any.  ``course`` (2, n):
    position and heading in each sample of a run.
    """

    law: str
    position: float | None = None
    heading: float | None = None
    binding: str = ""
    share: float | None = None
    linear: float | None = None
    push: float = 0.0
    pose: float = 0.0
    velocity: tuple[float, float] = (0.0, 0.0)
    mass: float = 0.0
    until: float | None = None
    refused: str = ""
    closes: float | None = None
    near: float = 1.0
    alone: bool = False
    clearance: Clearance | None = None
    masses: tuple[tuple[float, float], ...] | None = None
    start: tuple[float, float, float] = (0.0, 0.0, 0.0)
    position_late: float | None = None
    late: str = ""
    run: float | None = None
    anew: bool = False
    missing: int = 0
    whole: Corridor | None = None
    course: Floats | None = field(default=None, compare=False, repr=False)

    @property
    def merit(self) -> tuple[bool, float]:
        """Figure of merit for a search, smaller is better: whether it is refused, then a distance
        [m].

        A certified corridor ranks before any refused one, however wide it is.  The distance is the
        position; for a refused one that of the linear loop, inf without such a loop.
        """
        if self.position is not None:
            return False, self.position
        return True, math.inf if self.linear is None else self.linear

    @property
    def sentence(self) -> str:
        """One-sentence summary."""
        whole = "" if self.whole is None else self.whole._over_run
        beside = "" if self.clearance is None else f"; {self.clearance.sentence}"
        return f"{self._promise}{whole}{beside}"

    @property
    def _promise(self) -> str:
        if self.position is None:
            which = ALONE if self.alone else "it"
            closes = "" if self.closes is None else f"; {which} closes {self._closing(self.closes)}"
            return f"no corridor: {self.refused}{closes}"
        loaded = f", with {self.late}" if self.late else ""
        lasts = "" if self.until is None else f", until the robot changes at {self.until:g} s"
        lasts += "" if self.run is None else f", in a run of {self.run:g} s"
        return (
            f"corridor: within {self._off} and {self._turned} rad of its place "
            f"on the path, from a start {self._from} at its speed{loaded}, {self._while(1.0)} and "
            f"{self._mass}{lasts}; no limit and no guard acts there (most used: {self._used})"
        )

    @property
    def _over_run(self) -> str:
        """Clause on the whole run, after the promise for a part of it."""
        if self.position is None:
            return f"; over the whole run {self._promise}"
        idle = f"with {self.late} at first, " if self.late else ""
        return (
            f"; {idle}within {self._off} and {self._turned} rad over the whole "
            f"run of {self.run:g} s, where no limit and no guard acts either (most used: "
            f"{self._used})"
        )

    @property
    def _used(self) -> str:
        return f"{self.binding}, {100 * (self.share or 0.0):.0f} %"

    @property
    def _off(self) -> str:
        return length(max(_counted(self.position), self._least))

    @property
    def _turned(self) -> str:
        return rounded(max(_counted(self.heading), self._least), 2)

    @property
    def _least(self) -> float:
        """Smallest distance [m] and angle [rad] to print; larger if nothing disturbs the robot."""
        return 0.0 if self.push or self.pose or any(self.velocity) else COARSE

    @property
    def _from(self) -> str:
        ahead, aside, turn = self.start
        far = f"{length(ahead, up=False)} ahead, {length(aside, up=False)} aside"
        moved = f"{far} and {rounded(turn, 6, up=False)} rad"
        late, begun = (length(_counted(x)) for x in (self.position_late, self.position))
        when = "in the long run" if self.run is None else "in its second half"
        counted = any(self.start) or (late != begun and self.run is None)
        more = f" ({when} within {late})" if counted else ""
        return (f"on it, or moved there by up to {moved}" if any(self.start) else "on it") + more

    @property
    def _mass(self) -> str:
        if self.masses is None:
            return f"M = {self.mass:g} kg"
        also = ", after each change of mass or inertia anew" if self.anew else ""
        M, I = (f"{rounded(ends[0], 6)} to {rounded(ends[1], 6, up=False)}" for ends in self.masses)
        return f"M is anything from {M} kg, I from {I} kg m2{also}"

    def _while(self, share: float, more: str = ",") -> str:
        velocity = (share * self.velocity[0], share * self.velocity[1])
        reckoned = ""
        if self.missing:
            reckoned = f"{more} no pose comes to up to {self.missing} samples in a row"
        return f"while {bounds(share * self.push, share * self.pose, velocity)}{reckoned}"

    def _closing(self, share: float) -> str:
        """Clause on the disturbances and starts for which a corridor exists."""
        if self.near == 1 or not any(self.start):
            return self._while(share, ", and")
        if not self.near:
            return f"from a start on the path {self._while(share, ', and')}"
        return f"from {rounded(100 * self.near, 2, up=False)} % of corridor.start"

    @property
    def figures(self) -> dict[str, object]:
        """Its figures in `check --json`."""
        clearance = None if self.clearance is None else asdict(self.clearance)
        if self.position is None:
            return {
                "refused": self.refused, "closes": self.closes, "near": self.near,
                "clearance": clearance, "run": self.run, "linear": self.linear,
            }  # fmt: skip
        return {
            "position": _counted(self.position), "heading": _counted(self.heading),
            "start": list(self.start), "late": self.late,
            "position_late": _counted(self.position_late),
            "settling": 0.0,
            "binding": self.binding, "share": self.share, "linear": self.linear,
            "push": self.push, "pose": self.pose, "velocity": list(self.velocity),
            "missing": self.missing, "mass": self.mass, "masses": self.masses,
            "until": self.until, "clearance": clearance,
            "run": self.run,
            "whole": None if self.whole is None else self.whole.figures,
        }  # fmt: skip


def _counted(size: float | None) -> float:
    """A distance [m] or angle [rad] to print, at least 1e-9, as rounding is not modelled."""
    return max(size or 0.0, 1e-9)


def bounds(push: float, pose: float, velocity: tuple[float, float]) -> str:
    """Clause on the sizes of disturbances, rounded down: torque [N m], position [m], velocities."""
    parts = [f"each wheel is pushed by at most {rounded(push, 3, up=False)} N m"] * (push > 0)
    if pose > 0:
        parts.append(f"positions are measured to within {length(pose, up=False)}")
    if any(velocity):
        v, w = (rounded(x, 3, up=False) for x in velocity)
        parts.append(f"velocities to within {v} m/s and {w} rad/s")
    return ", ".join(parts) if parts else "nothing disturbs"
