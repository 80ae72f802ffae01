"""Tests whether one entry notices an altered function."""

from wmr_ctrl.results.ledger import OPEN, PROVED
from wmr_proofs import noticed
from wmr_proofs.alterations import built


def is_noticed(claim, name, change):
    """True if the claim is no longer PROVED with the function altered."""
    statement = built(claim, {name: change})
    return statement is not None and fails(claim, statement)


def fails(claim, statement):
    """True if the claim's method does not prove an altered statement.

    A failure within a short budget counts if the method proves the claim itself within one.
    """
    assert claim.method is not None
    verdict = noticed.verdict_of(noticed.short_budget(claim.method), statement)
    if verdict == OPEN and not noticed.proves_quickly(claim.id):
        verdict = noticed.verdict_of(claim.method, statement)
    return verdict != PROVED
