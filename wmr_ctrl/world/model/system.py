"""System: the one shape of plants, laws, references and estimators, and its Parameters.

A System is a set of CasADi SX expressions with named, unit-carrying ports. Code generation, the
compiled loop, FMUs, linearisation and proofs use only Systems.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass, field
from functools import cached_property
from typing import Protocol, TypeVar

from wmr_ctrl.core.signals import Signal
from wmr_ctrl.core.symbolic import ca

Number = TypeVar("Number", float, "ca.SX")
"""A formula's quantity: a number, or a symbol for a graph or a proof of it."""
UNIFORM, NORMAL = "uniform", "normal"
"""Kinds of draws."""


@dataclass(frozen=True)
class Port:
    """A symbol of the graph with its Signal and its value (start, default or parameter value)."""

    signal: Signal
    sym: ca.SX
    value: tuple[float, ...]


@dataclass(frozen=True)
class Output:
    """A named expression of the graph."""

    signal: Signal
    expr: ca.SX


@dataclass(frozen=True)
class Draw:
    """Random numbers for each sample of a block: one number, or two independent ones.

    ``kind``: "uniform" on [-1, 1), or "normal" with ``bound`` standard deviations as the largest (a
    pair beyond it is drawn again). ``wanted``: a truth value of the parameters; where it is 0
    nothing is drawn and the numbers are 0. The name of the port's signal picks the stream. A block
    at plant rate receives numbers of its step, or with ``held`` those of its control sample.
    """

    port: Port
    kind: str
    wanted: ca.SX
    bound: ca.SX
    held: bool = False


@dataclass(frozen=True)
class System:
    """One block: inputs u, state x and parameters p to the update, outputs y and diagnostics d.

    ``period`` is None for a continuous block, whose ``update`` is the state's rate; otherwise the
    block is sampled with that period [s] and ``update`` is the next state.  All vectors are columns
    in the order of their ports.  ``draws`` are random inputs, which only a loop can supply;
    ``transport`` is the delay of the inputs [s], implemented by a queue, not in the graph.
    """

    name: str
    title: str
    _: KW_ONLY
    inputs: tuple[Port, ...] = ()
    state: tuple[Port, ...] = ()
    params: tuple[Port, ...] = ()
    update: ca.SX = field(default_factory=lambda: ca.SX(0, 1))
    outputs: tuple[Output, ...] = ()
    diagnostics: tuple[Output, ...] = ()
    period: float | None = None
    draws: tuple[Draw, ...] = ()
    transport: ca.SX | None = None

    def __post_init__(self) -> None:
        """Check shapes, and that no symbol is free."""
        if self.update.numel() != self.x.numel():
            raise ValueError(
                f"{self.name}: {self.update.numel()} rows of update, {self.x.numel()} of state"
            )
        for item in (*self.outputs, *self.diagnostics):
            if item.expr.numel() != item.signal.size:
                raise ValueError(
                    f"{self.name}: {item.signal.name} has {item.expr.numel()} elements"
                )
        try:
            self.function("check", [self.update, self.y, self.d])
        except RuntimeError:
            free = {str(item) for item in ca.symvar(ca.vertcat(self.update, self.y, self.d))}
            free -= {str(item) for item in ca.symvar(ca.vertcat(self.u, self.x, self.p, self.w))}
            if not free:
                raise  # the symbol of another port of the same name
            raise ValueError(
                f"{self.name}: {', '.join(sorted(free))} belongs to no port. Take a parameter "
                "before `ports` of its Parameters is read."
            ) from None

    @cached_property
    def u(self) -> ca.SX:
        """Input vector."""
        return stack(port.sym for port in self.inputs)

    @cached_property
    def x(self) -> ca.SX:
        """State vector."""
        return stack(port.sym for port in self.state)

    @cached_property
    def p(self) -> ca.SX:
        """Parameter vector."""
        return stack(port.sym for port in self.params)

    @cached_property
    def w(self) -> ca.SX:
        """Vector of draws."""
        return stack(item.port.sym for item in self.draws)

    @cached_property
    def y(self) -> ca.SX:
        """Output vector."""
        return stack(item.expr for item in self.outputs)

    @cached_property
    def d(self) -> ca.SX:
        """Diagnostics vector."""
        return stack(item.expr for item in self.diagnostics)

    @property
    def x0(self) -> list[float]:
        """Start values of the state."""
        return values(self.state)

    @property
    def p0(self) -> list[float]:
        """Values of the parameters."""
        return values(self.params)

    def function(self, name: str, exprs: list[ca.SX]) -> ca.Function:
        """CasADi function (u, x, p) -> exprs, or (u, x, p, w) where there are draws w.

        Raises RuntimeError on a free symbol.
        """
        given = {"u": self.u, "x": self.x, "p": self.p, **({"w": self.w} if self.draws else {})}
        results = [f"out{i}" for i in range(len(exprs))]
        return ca.Function(name, list(given.values()), exprs, list(given), results)


def stack(parts: Iterable[ca.SX]) -> ca.SX:
    """Column of all parts; a 0-by-1 column where there is none."""
    columns = list(parts)
    return ca.vertcat(*columns) if columns else ca.SX(0, 1)


def values(ports: Iterable[Port]) -> list[float]:
    """Values of all ports, flat, in order."""
    return [float(number) for port in ports for number in port.value]


def port(signal: Signal, value: Iterable[float] | float = 0.0) -> Port:
    """A fresh symbol for ``signal``; a single number fills all its elements."""
    numbers = (float(value),) * signal.size if isinstance(value, int | float) else tuple(value)
    if len(numbers) != signal.size:
        raise ValueError(f"{signal.name} needs {signal.size} values, got {len(numbers)}")
    return Port(signal, ca.SX.sym(signal.name, signal.size), numbers)


def draw(
    signal: Signal, kind: str, wanted: ca.SX, bound: ca.SX | float = math.inf, *, held: bool = False
) -> Draw:
    """Fresh random numbers, as many as ``signal`` has elements: an even number."""
    if signal.size % 2:
        raise ValueError(f"{signal.name}: random numbers come in pairs, not {signal.size}")
    return Draw(port(signal), kind, ca.SX(wanted), ca.SX(bound), held)


def ports(signals: Iterable[Signal], start: Iterable[float] | None = None) -> tuple[Port, ...]:
    """Fresh symbols for signals, each with its start value if given."""
    listed = tuple(signals)
    numbers = tuple(start) if start is not None else (0.0,) * len(listed)
    return tuple(port(signal, number) for signal, number in zip(listed, numbers, strict=True))


def outputs(signals: Iterable[Signal], column: ca.SX) -> tuple[Output, ...]:
    """An Output for each of these scalar signals: the elements of a column."""
    return tuple(Output(signal, column[i]) for i, signal in enumerate(signals))


class KeyedNumbers(Protocol):
    """Numbers by key: a Scenario, or the Setup of a law on it."""

    def number(self, key: str) -> tuple[Signal, tuple[float, ...]]:
        """Signal and value of the number called ``key``, such as ``robot.m``."""


class Parameters:
    """Collects parameter ports in the order of their first use.

    Value, unit and meaning come from the field that a key names, so each is written once.
    """

    def __init__(self, numbers: KeyedNumbers, known: Iterable[Port] = ()) -> None:
        """Start with the ports of another System's graph, so that both share symbols."""
        self._numbers = numbers
        self._ports: dict[str, Port] = {port.signal.name: port for port in known}

    @property
    def ports(self) -> tuple[Port, ...]:
        """All parameters taken so far."""
        return tuple(self._ports.values())

    def take(self, key: str) -> ca.SX:
        """Symbol of the number ``key``: ``robot.m``, ``gains.mb.rho``, ``guard.dbar``.

        ``model.*`` is the laws' model of the robot. Raises KeyError for a key that names no number.
        """
        if key not in self._ports:
            signal, value = self._numbers.number(key)
            self._ports[key] = port(signal, value)
        return self._ports[key].sym
