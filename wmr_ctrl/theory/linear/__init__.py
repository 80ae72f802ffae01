"""Linear analysis in python-control's language: exact, named, and compared with nonlinear runs.

Start with `report_linear` for figures, `closed_loop` for a `control.StateSpace`, `loop_nlsys` for
the nonlinear loop; docs/linear.md is the guide.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
