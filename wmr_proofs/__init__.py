"""What needs python-flint or z3: claims about the graphs, methods that check them, corridor.

>>> from wmr_proofs import prove
>>> ledger = prove(only=["eq25"])  # doctest: +SKIP
>>> ledger.tally()  # doctest: +SKIP
{'PROVED': 1, 'REFUTED': 1}
"""

from wmr_ctrl.results.ledger import Entry as Entry
from wmr_ctrl.results.ledger import Ledger as Ledger
from wmr_ctrl.results.ledger import load as load

from .runner import prove as prove
