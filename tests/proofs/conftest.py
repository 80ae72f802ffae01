"""Tests of proofs need the optional packages; without them only the ledger's own tests run."""

from importlib.util import find_spec

import pytest

NEEDED = ("flint", "z3")
needs_packages = pytest.mark.skipif(
    any(find_spec(name) is None for name in NEEDED), reason="needs wmr_ctrl[proofs]"
)


def pytest_collection_modifyitems(items):
    for item in items:
        if "proofs" in str(item.fspath) and "ledger_file" not in str(item.fspath):
            item.add_marker(needs_packages)
