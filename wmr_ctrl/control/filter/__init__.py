"""The command filter of bases that take velocities: a command goes in, one that is safe comes out.

``clip`` and ``governor`` for bases whose speed follows its command by a first-order lag; ``clip``
too for chains that never overshoot and, by their peak gain, for linear loops that do.
`docs/explanation/filter.md` has the theorems and their hypotheses.
"""

from .filter import CommandFilter, command_filter, filter_system

__all__ = ["CommandFilter", "command_filter", "filter_system"]
