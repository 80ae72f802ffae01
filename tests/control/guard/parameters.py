"""A guard without a law, evaluated with other parameters than it was composed for."""

import numpy as np


def feasible_with(item, factors):
    """Return the guard's feasibility flag with some parameters multiplied by ``factors``."""
    names = [name for port in item.params for name in port.signal.elements]
    p = np.array(item.p0)
    for key, factor in factors.items():
        p[names.index(key)] *= factor
    return float(item.function("guard", [item.d])([10.0, 1.0, 0.1, 0.1], item.x0, p)[4])
