"""wmr_ctrl: velocity-constrained control of wheeled mobile robots, from laws to reports.

>>> import wmr_ctrl
>>> run = wmr_ctrl.simulate("paper-simulation", "nn", seed=3)  # doctest: +SKIP
>>> print(run.outcome)  # doctest: +SKIP

`__init__.pyi` lists the public names.  Each is loaded when it is first used, so that importing the
package costs little.
"""

import lazy_loader

from wmr_ctrl.version import __version__ as __version__

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
