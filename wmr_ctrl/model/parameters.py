"""Parameters: a scenario's numbers as symbols of one System, named by their scenario key."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields
from typing import Any

import casadi as ca

from wmr_ctrl.model.system import Port, port
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import Signal


class Parameters:
    """Collects parameter ports in the order of their first use.

    ``take("limits.v_u1")`` reads value, unit and meaning from the scenario's own field, so each is
    written once.  ``model.*`` resolves to what the laws believe (``scenario.believed``).
    """

    def __init__(self, scenario: Scenario, known: Iterable[Port] = ()) -> None:
        """Start with the ports of another System's graph, so that both share their symbols."""
        self._scenario = scenario
        self._ports: dict[str, Port] = {port.signal.name: port for port in known}

    @property
    def ports(self) -> tuple[Port, ...]:
        """All parameters taken so far."""
        return tuple(self._ports.values())

    def take(self, key: str) -> ca.SX:
        """Symbol of the scenario's field ``key``, such as ``robot.m``."""
        section, name = key.split(".")
        holder = self._scenario.believed if section == "model" else getattr(self._scenario, section)
        return self.field(key, holder, name)

    def field(self, key: str, holder: Any, name: str) -> ca.SX:
        """Symbol of one dataclass field, published under ``key``."""
        if key not in self._ports:
            meta = next(item.metadata for item in fields(holder) if item.name == name)
            self.declare(
                Signal(key, meta["unit"], meta["doc"], _size(getattr(holder, name))),
                getattr(holder, name),
            )
        return self._ports[key].sym

    def declare(self, signal: Signal, value: Any) -> ca.SX:
        """Symbol of a parameter that is not a scenario field."""
        if signal.name not in self._ports:
            self._ports[signal.name] = port(signal, value)
        return self._ports[signal.name].sym


def _size(value: Any) -> int:
    return len(value) if isinstance(value, tuple) else 1
