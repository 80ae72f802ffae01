"""Command filter of bases that take velocities: it changes a command into a safe one.

``clip`` and ``governor`` serve bases whose speed follows its command by a first-order lag.
``clip`` also serves chains that never overshoot and, through their peak gain, linear loops that do.
`docs/explanation/filter.md` has the theorems and their hypotheses.
"""

from .filter import CommandFilter, command_filter, filter_system

__all__ = ["CommandFilter", "command_filter", "filter_system"]
