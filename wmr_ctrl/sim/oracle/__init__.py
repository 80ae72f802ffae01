"""The closed loop once more, slow and obvious: the oracle, and ``--engine numpy``.

It is written from the definitions with plain Python scalars, shares no code with the compiled loop
or with the symbolic graphs, and is what both are compared with.
"""

from wmr_ctrl.sim.oracle.loop import simulate_oracle

__all__ = ["simulate_oracle"]
