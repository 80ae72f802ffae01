"""What theory says about a run, as values that the run can carry."""

from dataclasses import dataclass

from wmr_ctrl.core.fields.units import length


@dataclass(frozen=True)
class Warning:
    """A sentence that names the problem, its size and the remedy.

    ``key`` is the scenario's key (or ``law``) that the remedy starts from; ``equation`` names the
    place that the statement rests on: one of the paper, such as ``"Eq. (9)"``, or a limit.
    ``objects``: whether something is expected to go wrong; if not, a promise is only narrower than
    it might be, and a run that shows no fault needs no change.
    """

    key: str
    sentence: str
    equation: str
    objects: bool = True

    def __str__(self) -> str:
        """The sentence, then the place that it rests on."""
        return f"{self.sentence} [{self.equation}]"


@dataclass(frozen=True)
class Outlook:
    """Prior knowledge of a law's run on a scenario.

    ``tau_max``: torque limit of each wheel [N m], inf for none; ``warnings``: what theory says;
    ``exact_pose``: whether the pose is perfect while velocities come from encoders; ``known``:
    whether the law is, and so was checked; ``barrier``: speeds [m/s, rad/s] at which that of the
    law begins, None for a law without; ``assumed``: keys that nobody stated.
    """

    tau_max: float
    warnings: tuple[Warning, ...]
    exact_pose: bool
    known: bool = True
    barrier: tuple[float, float] | None = None
    assumed: tuple[str, ...] = ()

    @property
    def objections(self) -> tuple[Warning, ...]:
        """Warnings by which something is expected to go wrong."""
        return tuple(item for item in self.warnings if item.objects)


@dataclass(frozen=True)
class CorridorLeft:
    """A run that was settled in its corridor from ``since`` [s] on, and left it at ``time`` [s].

    ``distance`` [m] from its place on the path then, of which ``most`` [m] is certified while
    the ``assumptions`` hold.
    """

    time: float
    distance: float
    most: float
    since: float
    assumptions: str

    @property
    def sentence(self) -> str:
        """All of it in words, with what follows."""
        return (
            f"At t = {self.time:.4g} s the robot was {length(self.distance)} from its place on the "
            f"path. From t = {self.since:.4g} s on it was settled there, and no more than "
            f"{length(self.most)} are possible while {self.assumptions}: one of these was not so, "
            "or inertia, friction or drives are not those of the scenario, or the robot does what "
            "the plane model cannot, such as slip. Look for what pushes it, or state larger bounds."
        )
