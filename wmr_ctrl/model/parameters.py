"""Parameters: a scenario's numbers as symbols of one System, named by their scenario key."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

from wmr_ctrl.model.system import Port, port
from wmr_ctrl.signals import Signal
from wmr_ctrl.symbolic import ca


class KeyedNumbers(Protocol):
    """Where numbers come from by key: a Scenario, or the Setup of a law on it."""

    def number(self, key: str) -> tuple[Signal, tuple[float, ...]]:
        """Signal and value of the number called ``key``, such as ``robot.m``."""


class Parameters:
    """Collects parameter ports in the order of their first use.

    Value, unit and meaning come from the field that a key names, so each is written once.
    """

    def __init__(self, numbers: KeyedNumbers, known: Iterable[Port] = ()) -> None:
        """Start with the ports of another System's graph, so that both share their symbols."""
        self._numbers = numbers
        self._ports: dict[str, Port] = {port.signal.name: port for port in known}

    @property
    def ports(self) -> tuple[Port, ...]:
        """All parameters taken so far."""
        return tuple(self._ports.values())

    def take(self, key: str) -> ca.SX:
        """Symbol of the number ``key``: ``robot.m``, ``gains.mb.rho``, ``guard.dbar``.

        ``model.*`` is what the laws believe.  Raises KeyError for a key that names no number.
        """
        if key not in self._ports:
            signal, value = self._numbers.number(key)
            self._ports[key] = port(signal, value)
        return self._ports[key].sym
