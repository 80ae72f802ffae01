"""The certified corridor: how far from its path a robot can be pushed, with a proof.

Start with `find_corridor`; docs/corridor.md has the theorem, and what it does not cover.
"""

from functools import lru_cache
from importlib.util import find_spec

from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.corridor.answer import Corridor as Corridor
from wmr_ctrl.scenario import Scenario

NOT_CHECKED = (
    "NOT_CHECKED: the certificate takes ball arithmetic; install wmr-ctrl[proofs], which has "
    "python-flint"
)


def find_corridor(scenario: Scenario, law: str) -> Corridor:
    """The Corridor of ``law`` on ``scenario``; raises what `settle` raises.

    Without python-flint (the extra ``proofs``) its ``refused`` is NOT_CHECKED.
    """
    return _of(settle(scenario, law))


@lru_cache(maxsize=256)
def _of(setup: Setup) -> Corridor:
    if find_spec("flint") is None:
        return Corridor(setup.name, refused=NOT_CHECKED)
    from wmr_ctrl.corridor.certificate import certified

    return certified(setup)
