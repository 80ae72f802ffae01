"""The closed loop once more, slow and obvious: what both engines and the graphs are compared with.

It is written from the definitions with plain Python scalars, and shares no code with the compiled
loop or with the symbolic graphs.  Of the product it uses scenarios, signals, and what makes a Run
of columns.
"""

from tests.oracle.loop import simulate_oracle
from wmr_ctrl.control.controller import watched_controller
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.control.laws.context import own_diagnostics
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.signals import LOG_HEAD
from wmr_ctrl.results import Monitor
from wmr_ctrl.simulation.runnable import assemble_run

__all__ = ["simulate", "simulate_oracle"]


def simulate(
    scenario,
    law,
    *,
    seed=0,
    guard=None,
    overrides=None,
):
    """One run, as `wmr_ctrl.simulate`; raises ValueError for what has no twin here."""
    setup = settle(scenario_of(scenario, overrides, guard), law)
    drives, stated = setup.scenario.actuator, setup.scenario.guard
    if stated.delay is not None or stated.lag is not None:
        raise ValueError("the guard's twin knows no guard.delay and guard.lag")
    if stated.enabled and not setup.guard.knows_force(drives.delay, drives.lag):
        raise ValueError(
            "the guard's twin knows no actuator.unmodelled_delay and actuator.lag_spread"
        )
    own = {signal.name: signal for signal in own_diagnostics(watched_controller(setup))}
    columns, numbers = simulate_oracle(
        setup.scenario,
        law,
        vars(setup.gains),
        vars(setup.kinematics),
        seed,
        effects=[item.name for item in setup.effects],
    )
    signals = (*LOG_HEAD, *(own[name] for name in columns if name in own))
    logged = (signals, columns, Monitor(**numbers))
    return assemble_run(setup.scenario, law, seed, "oracle", logged, {}, setup.assumptions)
