"""Corridor: how far a law's robot is off its path at most, as a value and in words.

Worked out by `wmr_ctrl.corridor.certificate`, which takes python-flint.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Corridor:
    """Certified distance of a law's robot from its path, or why there is none.

    ``position`` [m] and ``heading`` [rad]: the most that the robot is ever off its place on the
    path, at plant steps, if it starts there.  ``linear`` [m]: what a linear loop would leave of the
    position, which a push attains.  ``binding`` names what comes nearest to acting (the wheels'
    limit, the guard, a limit of the law), ``share`` how near.

    ``push``: largest torque on each wheel [N m], held over a sample; ``pose``: the most that the
    measured position is off [m]; ``velocity``: the same of each measured velocity; ``mass`` [kg].
    ``until`` [s]: the robot's first change, None without one.

    ``refused`` says why there is none; ``closes``: share of push and errors with which there is.
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

    @property
    def sentence(self) -> str:
        """All of it in words."""
        if self.position is None:
            closes = "" if self.closes is None else f"; it closes {self._while(self.closes)}"
            return f"no corridor: {self.refused}{closes}"
        lasts = "" if self.until is None else f", until the robot changes at {self.until:g} s"
        return (
            f"corridor: within {_length(self.position)} and {self.heading:.2g} rad of its place "
            f"on the path, from a start on it at its speed, {self._while(1.0)} and "
            f"M = {self.mass:g} kg{lasts}; no limit and no guard acts there (most used: "
            f"{self.binding}, {_percent(self.share)})"
        )

    def _while(self, share: float) -> str:
        parts = [f"each wheel is pushed by at most {share * self.push:.3g} N m"] * (self.push > 0)
        if self.pose > 0:
            parts.append(f"positions are measured to within {_length(share * self.pose)}")
        if any(self.velocity):
            first, second = (share * value for value in self.velocity)
            parts.append(f"velocities to within {first:.3g} m/s and {second:.3g} rad/s")
        return "while " + (", ".join(parts) if parts else "nothing disturbs")

    @property
    def figures(self) -> dict[str, object]:
        """What `check --json` has of it."""
        if self.position is None:
            return {"refused": self.refused, "closes": self.closes}
        return {
            "position": self.position, "heading": self.heading, "start": [0.0, 0.0, 0.0],
            "binding": self.binding, "share": self.share, "linear": self.linear,
            "push": self.push, "pose": self.pose, "velocity": list(self.velocity),
            "mass": self.mass, "until": self.until,
        }  # fmt: skip


def _length(value: float) -> str:
    return f"{1e3 * value:.3g} mm" if value < 0.1 else f"{value:.3g} m"


def _percent(share: float | None) -> str:
    return "" if share is None else f"{100 * share:.0f} %"
