"""A controller with the velocity guard behind it, as one part of a co-simulation.

Both take their sample at the same instant: the guard sees the force that the controller asks for
and the velocity that it was shown, and its torques are those of this part.  So the loop is the one
that a controller with the guard in it gives, under either master.
"""

from __future__ import annotations

from collections.abc import Sequence

from wmr_ctrl.fmi.cosim.parts import SEEN, Part
from wmr_ctrl.signals import FORCE, VELOCITY

_VELOCITY = tuple(SEEN.index(signal.name) for signal in VELOCITY)
_ASKED = len(FORCE.elements)


class GuardedController:
    """What a master asks of a controller; see `parts.Part`."""

    foreign = False

    def __init__(self, controller: Part, guard: Part) -> None:
        """``controller`` gives the force that it asks for first, then diagnostics of its own."""
        self.controller, self.guard = controller, guard
        self.wants_ready = controller.wants_ready
        own = controller.targets[_ASKED:]
        self._own = [_ASKED + i for i, name in enumerate(own) if name not in guard.targets]
        self.targets = (*guard.targets, *(controller.targets[i] for i in self._own))
        self._velocity: tuple[float, ...] = ()
        self._told: list[float] = []

    def write(self, values: Sequence[float]) -> None:
        """Show the controller what it sees; the guard takes the same velocity."""
        self.controller.write(values)
        self._velocity = tuple(values[i] for i in _VELOCITY)

    def step(self, t: float, h: float) -> None:
        """The controller, then the guard on what it asks for."""
        self.controller.step(t, h)
        given = self.controller.read()
        self._told = [given[i] for i in self._own]
        self.guard.write((*given[:_ASKED], *self._velocity))
        self.guard.step(t, h)

    def read(self) -> Sequence[float]:
        """Torques and diagnostics of the guard, then those of the controller."""
        return [*self.guard.read(), *self._told]
