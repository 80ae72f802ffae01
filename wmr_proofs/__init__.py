"""Proofs with python-flint and z3: claims about the graphs, methods that check them, corridor.

>>> from wmr_proofs import prove
>>> ledger = prove(only=["eq25"])  # doctest: +SKIP
>>> ledger.tally()  # doctest: +SKIP
{'PROVED': 1, 'REFUTED': 1}
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from wmr_ctrl.results.ledger import Entry as Entry
    from wmr_ctrl.results.ledger import Ledger as Ledger
    from wmr_ctrl.results.ledger import load as load

    from .runner import prove as prove

LEDGER = "wmr_ctrl.results.ledger"
PLACES = {"prove": "wmr_proofs.runner", "Entry": LEDGER, "Ledger": LEDGER, "load": LEDGER}


def __getattr__(name: str) -> Any:
    """A public name, loaded when first used: `wmr_proofs.check` runs without any other package."""
    if name not in PLACES:
        raise AttributeError(f"module 'wmr_proofs' has no attribute {name!r}")
    return vars(import_module(PLACES[name]))[name]
