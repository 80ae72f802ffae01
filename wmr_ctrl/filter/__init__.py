"""The command filter of bases that take velocities: a command goes in, one that is safe comes out.

``clip`` and ``governor`` for bases whose speed follows its command by a first-order lag (or by any
chain that never overshoots: clip alone); `docs/filter.md` has the theorem and its hypotheses.
"""

from wmr_ctrl.filter.filter import CommandFilter, command_filter, filter_system

__all__ = ["CommandFilter", "command_filter", "filter_system"]
