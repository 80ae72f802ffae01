"""Prove a claim from the graphs as they are now, without the committed ledger."""

from __future__ import annotations  # functions are compiled with it, since types may not be there

import inspect
import textwrap
from contextlib import contextmanager
from types import FunctionType

from wmr_proofs.claim import CLAIMED, MUTATED
from wmr_proofs.claims import all_claims, forget


def claim_of(key):
    """The claim with this id."""
    return next(claim for claim in all_claims() if claim.id == key)


def verdict(claim):
    """Verdict of the claim's own method on its statement."""
    assert claim.statement is not None
    assert claim.method is not None
    return claim.method.decide(claim.statement(CLAIMED)).verdict


def assert_proved(key):
    """The claim is proved, some point meets its hypotheses, and the claim altered is refuted."""
    claim = claim_of(key)
    assert claim.statement is not None
    assert claim.method is not None
    found = claim.method.decide(claim.statement(CLAIMED))
    assert found.verdict == "PROVED", key
    assert found.point is not None, f"{key}: no point meets the hypotheses"
    assert claim.method.decide(claim.statement(MUTATED)).verdict == "REFUTED", key


@contextmanager
def altered(function, old, new):
    """Run the function with ``new`` in place of the first ``old``, wherever it was imported."""
    assert isinstance(function, FunctionType)
    lines = textwrap.dedent(inspect.getsource(function)).splitlines()
    source = "\n".join(line for line in lines if not line.startswith("@"))
    head, body = source.split('"""', 1)[0], source.split('"""', 2)[2]
    assert old in body, source
    space = {}
    exec(
        compile(head + "pass" + body.replace(old, new, 1), "altered", "exec"),
        dict(function.__globals__),
        space,
    )
    original = function.__code__
    function.__code__ = space[function.__name__].__code__
    forget()
    try:
        yield
    finally:
        function.__code__ = original
        forget()
