"""Closed loop as a scan of JAX: the same graphs, written as operations of jax.numpy.

Elementary functions are XLA's and random numbers JAX's, so it agrees with the compiled loop but for
rounding and draws.  It sums what `benchmarks.gpu` asks of a study: squared position errors, and
plant steps beyond a limit.
"""

import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import casadi as ca
import jax
import jax.numpy as jnp

from wmr_ctrl.codegen.build import program_of
from wmr_ctrl.codegen.functions import loop_functions
from wmr_ctrl.codegen.kernels import loop_kernels
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.control.loop import SEEN
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.signals import PLANT_STATE, VELOCITY
from wmr_ctrl.world.model.graph import SELECT, Graph

jax.config.update("jax_enable_x64", True)
Vector = Any

OPERATIONS: dict[int, Callable[..., Any]] = {
    SELECT: jnp.where,
    ca.OP_ADD: jnp.add, ca.OP_SUB: jnp.subtract, ca.OP_MUL: jnp.multiply, ca.OP_DIV: jnp.divide,
    ca.OP_NEG: jnp.negative, ca.OP_SQ: jnp.square, ca.OP_TWICE: lambda a: 2.0 * a,
    ca.OP_INV: lambda a: 1.0 / a, ca.OP_FMIN: jnp.minimum, ca.OP_FMAX: jnp.maximum,
    ca.OP_FABS: jnp.abs, ca.OP_CONSTPOW: jnp.power, ca.OP_POW: jnp.power, ca.OP_SQRT: jnp.sqrt,
    ca.OP_LT: jnp.less, ca.OP_LE: jnp.less_equal, ca.OP_EQ: jnp.equal, ca.OP_NE: jnp.not_equal,
    ca.OP_AND: jnp.logical_and, ca.OP_OR: jnp.logical_or, ca.OP_NOT: jnp.logical_not,
    ca.OP_SIN: jnp.sin, ca.OP_COS: jnp.cos, ca.OP_TAN: jnp.tan, ca.OP_TANH: jnp.tanh,
    ca.OP_EXP: jnp.exp, ca.OP_LOG: jnp.log, ca.OP_LOG1P: jnp.log1p, ca.OP_EXPM1: jnp.expm1,
    ca.OP_FLOOR: jnp.floor, ca.OP_CEIL: jnp.ceil, ca.OP_SIGN: jnp.sign, ca.OP_ATAN: jnp.arctan,
    ca.OP_ATAN2: jnp.arctan2, ca.OP_ASIN: jnp.arcsin, ca.OP_ACOS: jnp.arccos,
    ca.OP_HYPOT: jnp.hypot, ca.OP_SINH: jnp.sinh, ca.OP_COSH: jnp.cosh,
    ca.OP_COPYSIGN: jnp.copysign,
}  # fmt: skip


def evaluated(graph: Graph, outputs: Sequence[str], given: dict[str, Vector]) -> list[Vector]:
    """The output vectors of a graph for some input vectors."""
    values: list[Any] = []
    for node in graph.nodes:
        if node.place is not None:
            values.append(given[node.place[0]][node.place[1]])
        elif node.leaf:
            values.append(node.number)
        else:
            values.append(OPERATIONS[node.op](*(values[k] for k in node.operands)))
    found: dict[str, list[Any]] = {name: [] for name in outputs}
    for store in sorted(graph.stores, key=lambda item: item.index):
        found[store.vector].append(jnp.asarray(values[store.node], dtype=float))
    return [jnp.stack(found[name]) for name in outputs]


def run_of(scenario: str, law: str) -> Callable[[Any], Any]:
    """Function from a JAX key to (sum of squared position errors, steps beyond a limit) of a run.

    The loop's commands must not be late, and it draws only the normal numbers that are wanted.
    """
    setup = settle(scenario_of(scenario), law)
    loop, numbers = program_of(setup).loop, loop_functions(setup)
    _, _, sample, step = (item.graph for item in loop_kernels(loop))
    known, clock = numbers.numbers, setup.scenario.clock
    assert known.delay_steps == 0
    rows, begins = jnp.array(known.parameters), jnp.array(known.phase_start)
    fast, substeps = loop.next_fast.numel(), round(clock.control / clock.plant)
    place = PLANT_STATE.index(VELOCITY[0])
    limits = jnp.array(numbers.limits)
    count = [sum(item.size for item in rate) for rate in (numbers.sampled, numbers.stepped)]
    wanted = [
        jnp.array([float(s.wanted) for s in rate for _ in range(s.size)] or [0.0])
        for rate in (numbers.sampled, numbers.stepped)
    ]

    def drawn(key: Any, rate: int) -> Any:
        return jax.random.normal(key, (max(count[rate], 1),)) * wanted[rate]

    def at(i: Any) -> Any:
        return rows[jnp.sum(begins <= i) - 1]

    def stepped(j: Any, carry: Any, k: Any, held: Any, key: Any) -> Any:
        x, beyond = carry
        i = k * substeps + j
        given = {"i": jnp.array([i], dtype=float), "u": held, "x": x, "p": at(i)}
        given["w"] = drawn(jax.random.fold_in(key, j), 1) if count[1] else jnp.zeros(1)
        (moved,) = evaluated(step, ("next",), given)
        return moved, beyond + jnp.any(jnp.abs(moved[place : place + 2]) > limits)

    def sampled(carry: Any, k: Any, key: Any) -> Any:
        x, squares, beyond = carry
        own = jax.random.fold_in(key, k)
        given = {"k": jnp.array([k], dtype=float), "x": x, "p": at(k * substeps)}
        given["w"] = drawn(own, 0) if count[0] else jnp.zeros(1)
        slow, held, seen = evaluated(sample, ("next", "held", "seen"), given)
        inner = partial(stepped, k=k, held=held, key=own)
        moved, beyond = jax.lax.fori_loop(0, substeps, inner, (x[:fast], beyond))
        squares += seen[SEEN.index("position")]
        return (jnp.concatenate([moved, slow]), squares, beyond), None

    def run(key: Any) -> Any:
        start = (jnp.array(known.start), jnp.array(0.0), jnp.array(0))
        end, _ = jax.lax.scan(partial(sampled, key=key), start, jnp.arange(clock.samples))
        return end[1:]

    return run


def pace(scenario: str, law: str, batch: int) -> str:
    """One sentence: the time of a million runs [s] in batches of this size."""
    run = jax.jit(jax.vmap(run_of(scenario, law)))
    keys = [jax.random.split(jax.random.key(seed), batch) for seed in (0, 1)]
    start = time.perf_counter()
    jax.block_until_ready(run(keys[0]))
    first = time.perf_counter() - start
    start = time.perf_counter()
    squares, beyond = jax.block_until_ready(run(keys[1]))
    took = time.perf_counter() - start
    rms = float(jnp.sqrt(jnp.mean(squares) / scenario_of(scenario).clock.samples))
    return (
        f"JAX {jax.__version__} on {jax.devices()[0].device_kind}, {law}, {batch} at a time: a "
        f"million runs in {took * 1e6 / batch:.1f} s, compiled in {first - took:.0f} s "
        f"(position RMS {1e3 * rms:.3f} mm, {int(beyond.sum())} steps beyond)"
    )
