"""A finished run: its log, outcome, figures of merit and files; the committed ledger of proofs.

`__init__.pyi` lists what other rooms import from here; each name is loaded when it is first used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
