"""Statements of theory about a run, as values that the run can carry."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from wmr_ctrl.core.fields.units import length


@dataclass(frozen=True)
class Warning:
    """A sentence that names the problem, its size and the remedy.

    ``key`` is the scenario's key (or ``law``) that the remedy starts from; ``equation`` names the
    basis of the statement: a place in the paper, such as ``"Eq. (9)"``, or a limit. ``objects``:
    whether a fault is expected; if not, a guarantee is only weaker than it could be, and a run
    without a fault needs no change.
    """

    key: str
    sentence: str
    equation: str
    objects: bool = True

    def __str__(self) -> str:
        """The sentence, then its basis."""
        return f"{self.sentence} [{self.equation}]"


@dataclass(frozen=True)
class Outlook:
    """Knowledge about a law's run on a scenario in advance.

    ``tau_max``: torque limit of each wheel [N m], inf for none.  ``warnings``: those of theory.
    ``exact_pose``: whether the pose is perfect while velocities come from encoders.  ``known``:
    whether the law is known, and so was checked.  ``barrier``: speeds [m/s, rad/s] at which the
    law's barrier begins, None without a barrier.  ``assumed``: keys that nobody stated.
    ``causes``: how the base changed the run's commands, as sentences by the remark's key.
    """

    tau_max: float
    warnings: tuple[Warning, ...]
    exact_pose: bool
    known: bool = True
    barrier: tuple[float, float] | None = None
    assumed: tuple[str, ...] = ()
    causes: Mapping[str, str] = field(default_factory=dict)

    @property
    def objections(self) -> tuple[Warning, ...]:
        """Warnings that expect a fault."""
        return tuple(item for item in self.warnings if item.objects)


@dataclass(frozen=True)
class CorridorLeft:
    """A run that had settled in its corridor since ``since`` [s], and left it at ``time`` [s].

    ``distance`` [m] is its distance from its place on the path then; ``most`` [m] is certified
    while the ``assumptions`` hold.
    """

    time: float
    distance: float
    most: float
    since: float
    assumptions: str

    @property
    def sentence(self) -> str:
        """One-sentence summary with the conclusion."""
        return (
            f"At t = {self.time:.4g} s the robot was {length(self.distance)} from its place on the "
            f"path. From t = {self.since:.4g} s on it was settled there, and no more than "
            f"{length(self.most)} are possible while {self.assumptions}: one of these was not so, "
            "or inertia, friction or drives are not those of the scenario, or the robot does what "
            "the plane model cannot, such as slip. Look for what pushes it, or state larger bounds."
        )
