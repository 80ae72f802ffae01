"""A second closed loop, slow and simple, to compare both engines and the graphs with.

It is written from the definitions with plain Python scalars, and shares no code with the compiled
loop or with the symbolic graphs.  From the product it uses scenarios, signals, and the construction
of a Run from columns.
"""

import numpy as np

from tests.oracle.loop import TWINS, _Loop
from wmr_ctrl.control.controller import watched_controller
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.control.laws.context import own_diagnostics
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.signals import LOG_HEAD
from wmr_ctrl.results import Monitor
from wmr_ctrl.simulation.runnable import assemble_run


def simulate(scenario, law, *, seed=0, guard=None, overrides=None):
    """Simulate one run, as `wmr_ctrl.simulate`; ValueError for effects without a twin here."""
    setup = settle(scenario_of(scenario, overrides, guard), law)
    drives, stated = setup.scenario.actuator, setup.scenario.guard
    guessed = stated.enabled and not setup.guard.knows_force(drives.delay, drives.lag)
    if guessed or stated.delay is not None or stated.lag is not None:
        raise ValueError("the guard's twin knows no other delay and lag than the drives'")
    if further := {item.name for item in setup.effects} - TWINS:
        raise ValueError(f"these effects have no twin: {further}")
    loop = _Loop(setup.scenario, law, vars(setup.gains), vars(setup.kinematics), seed)
    with np.errstate(over="ignore", invalid="ignore"):  # a run that overflows ends with a reason
        loop.run()
    columns = loop.log.columns()
    own = {signal.name: signal for signal in own_diagnostics(watched_controller(setup))}
    signals = (*LOG_HEAD, *(own[name] for name in columns if name in own))
    logged = (signals, columns, Monitor(**loop.watch.numbers()))
    return assemble_run(setup.scenario, law, seed, "oracle", logged, {}, setup.assumptions)
