"""System: the one shape of plants, laws, references and estimators.

A System is a set of CasADi SX expressions with named, unit-carrying ports.  Code generation, the
compiled loop, FMUs, linearisation and proofs read nothing else.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import casadi as ca

from wmr_ctrl.signals import Signal


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
class System:
    """One block: inputs u, state x and parameters p to the update, outputs y and diagnostics d.

    ``period`` is None for a continuous block, whose ``update`` is the state's rate; otherwise the
    block is sampled with that period [s] and ``update`` is the next state.  All vectors are columns
    in the order of their ports.
    """

    name: str
    title: str
    inputs: tuple[Port, ...]
    state: tuple[Port, ...]
    params: tuple[Port, ...]
    update: ca.SX
    outputs: tuple[Output, ...]
    diagnostics: tuple[Output, ...] = ()
    period: float | None = None

    def __post_init__(self) -> None:
        """Check shapes and that no symbol is free."""
        if self.update.numel() != self.x.numel():
            raise ValueError(
                f"{self.name}: {self.update.numel()} rows of update, {self.x.numel()} of state"
            )
        for item in (*self.outputs, *self.diagnostics):
            if item.expr.numel() != item.signal.size:
                raise ValueError(
                    f"{self.name}: {item.signal.name} has {item.expr.numel()} elements"
                )
        self.function("check", [self.update, self.y, self.d])

    @property
    def u(self) -> ca.SX:
        """Input vector."""
        return stack(port.sym for port in self.inputs)

    @property
    def x(self) -> ca.SX:
        """State vector."""
        return stack(port.sym for port in self.state)

    @property
    def p(self) -> ca.SX:
        """Parameter vector."""
        return stack(port.sym for port in self.params)

    @property
    def y(self) -> ca.SX:
        """Output vector."""
        return stack(item.expr for item in self.outputs)

    @property
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
        """CasADi function (u, x, p) -> exprs; raises RuntimeError on a free symbol."""
        return ca.Function(
            name,
            [self.u, self.x, self.p],
            exprs,
            ["u", "x", "p"],
            [f"out{i}" for i in range(len(exprs))],
        )


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


def ports(signals: Iterable[Signal], start: Iterable[float] | None = None) -> tuple[Port, ...]:
    """Fresh symbols for scalar signals, with start values where given."""
    listed = tuple(signals)
    numbers = tuple(start) if start is not None else (0.0,) * len(listed)
    return tuple(port(signal, number) for signal, number in zip(listed, numbers, strict=True))
