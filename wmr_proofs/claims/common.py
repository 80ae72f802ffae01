"""Common to the claims: one axis of the barrier, and a law's System with free inner quantities."""

from collections.abc import Iterable
from functools import cached_property
from typing import Any

from casadi import SX, fmax, fmin

from wmr_ctrl.control.barrier.stable import SERIES_BELOW, Barrier, stable_barrier
from wmr_ctrl.control.controller import law_graph
from wmr_ctrl.control.laws.context import LawContext
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.model.system import Port, System
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs import paper_barrier as barrier
from wmr_proofs.claim import rows
from wmr_proofs.statement import Cuts, Named, Relations, Symbols, exchanged, symbols

PRESET = "paper-simulation"
VELOCITY_NAMES = ("v1", "omega")
CLOSED_FORM = {SERIES_BELOW: False}


WAYS = {"ahead": {"way": 1}, "back": {"way": -1}}
BOTH_AXES = {"linear": {"axis": 0}, "angular": {"axis": 1}}


def named_axes(angular: str = "-angular") -> tuple[dict[str, Any], ...]:
    """Tables of both axes; the id of the angular entry gets the ending ``angular``."""
    return rows(axis=(0, 1), of=("", angular), where=("linear", "angular"))


EITHER_BARRIER = {"paper": {"smooth": False}, "smooth": {"smooth": True}}


def elements_of(*ports: Port) -> Symbols:
    """Symbols of ports by name and place, such as "tau.1"."""
    sizes = ((item, k) for item in ports for k in range(item.signal.size))
    return Symbols({f"{item.signal.name}.{k + 1}": item.sym[k] for item, k in sizes})


def named_ports(*ports: Port) -> Symbols:
    """Symbols of ports by their names, columns as they are."""
    return Symbols({item.signal.name: item.sym for item in ports})


def ports_of(system: System) -> tuple[Port, ...]:
    """Inputs, state and parameters of a system."""
    return *system.inputs, *system.state, *system.params


class BarrierAxis(Named):
    """Symbols v, c, u1, u2 of one axis with the paper's functions of them.

    ``all`` are these four, ``x`` is v_c1 of Eq. (18), ``w`` is v - v_c1.
    """

    def __init__(self, suffix: str = "") -> None:
        s = self.suffix = suffix
        self.symbols = symbols(f"v{s} c{s} u1{s} u2{s}", f"u1{s} u2{s}")
        v, c, u1, u2 = self.symbols.values()
        self.all = (v, c, u1, u2)
        self.x = barrier.minimiser(c, u1, u2)
        self.w = v - self.x

    @cached_property
    def A(self) -> SX:
        """A of Eq. (10)."""
        return barrier.a_term(*self.all)

    @cached_property
    def V(self) -> SX:
        """V1i of Eq. (20)."""
        return barrier.lyapunov(*self.all)

    def cost(self, v: SX) -> SX:
        """(v - v_c0)^2/2 + f(v), which v_c1 makes least."""
        _, c, u1, u2 = self.all
        return 0.5 * (v - c) ** 2 + barrier.f(v, u1, u2)

    @cached_property
    def stable(self) -> Barrier:
        """Compiled form."""
        v, c, u1, u2 = self.all
        return stable_barrier(c, v, u1, u2)

    @property
    def inside(self) -> Relations:
        """0 < u2 < u1 and |v| < u1, as hypotheses."""
        v, _, u1, u2 = self.all
        return u2 > 0, u1 > u2, u1 > v, v > -u1


def barrier_axis() -> tuple[BarrierAxis, SX, SX, SX, SX]:
    """One axis, and its v, c, u1, u2."""
    axis = BarrierAxis()
    return axis, *axis.all


def scalars(ports: Iterable[Port]) -> Symbols:
    """Every element of the ports by its name, counted from 1."""
    named = ((name, port.sym[i]) for port in ports for i, name in enumerate(port.signal.elements))
    return Symbols(named)


class LawGraph(Named):
    """A law's System and, in the same symbols, the inner quantities that all laws share.

    ``options`` are the law's own choices of form, such as ("gains.mb.decay", "exact"), in a preset
    whose numbers stay symbols; ``force`` is the generalised force, and ``context`` has the shared
    quantities in symbols of their own (see `own`).
    """

    def __init__(self, name: str, *options: tuple[str, str]) -> None:
        law = settle(load_scenario(PRESET, dict(options)), name)
        self.system, self.context = law_graph(law), LawContext(law)
        self.symbols = scalars(ports_of(self.system))
        self.force = self.system.outputs[0].expr

    def own(self, expr: SX) -> SX:
        """An expression of `context` in the System's symbols."""
        context, system = self.context, self.system
        shared = named_ports(*context.inputs, *context.parameters.ports)
        return exchanged(expr, shared, named_ports(*system.inputs, *system.params))

    def clipped(self, axis: int) -> SX:
        """The velocity that barrier quantities see: kept off the limit by limits.clip."""
        u1, clip = self[f"limits.v_u1[{axis + 1}]"], self["limits.clip"]
        return fmax(clip - u1, fmin(u1 - clip, self[VELOCITY_NAMES[axis]]))

    def inner(self, axis: int) -> Cuts:
        """Cuts: v_c0 and its rate as c and cdot, the velocity behind the clip as the velocity."""
        target, rate = self.own(self.context.v_c0), self.own(self.context.v_c0_dot)
        return {"c": target[axis], "cdot": rate[axis], VELOCITY_NAMES[axis]: self.clipped(axis)}

    def parts(self, axis: int, names: str) -> Cuts:
        """Cuts of these names: V1/A (quotient), q, w, v_c0' (cdot) and friction of one axis."""
        own, context = self.context.barrier[axis], self.context
        known = {
            "quotient": own.V1_over_A, "q": own.q, "w": own.w,
            "cdot": context.v_c0_dot[axis], "friction": context.friction[axis],
        }  # fmt: skip
        return {name: self.own(known[name]) for name in names.split()}
