"""What authors of laws, sensors, drives, references and figures of merit import.

`extend.pyi` lists the names, docs/extending.md has a complete example of each.  A name is loaded
when it is first used, so that the file of an effect does not load CasADi before it builds a graph.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub("wmr_ctrl", __file__)
