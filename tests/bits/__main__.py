"""Every law in every case on every platform: ``python -m tests.bits [NAME ...]``; some 20 minutes.

Each line has a platform, a law and the result; without names, all platforms.  The tests take a part
of these, in which every law occurs.
"""

import sys
import tempfile
from itertools import product
from pathlib import Path

import pytest

from tests.bits.cases import CASES
from tests.bits.platforms import differences
from tests.bits.test_same_bits import EVERYWHERE
from wmr_ctrl.control.laws.registry import NAMES


def said(platform, law):
    """Outcome of all cases of a law on a platform, in one line."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            found = differences(platform, law, CASES, Path(folder))
        except pytest.skip.Exception as reason:
            return str(reason)
    return "; ".join(found) or "the same bits"


def main(names):
    """Print a line for each; 1 if any bit differs."""
    chosen = [item for name, item in EVERYWHERE.items() if name in names or not names]
    failed = not chosen
    for platform, law in product(chosen, NAMES):
        text = said(platform, law)
        failed |= text != "the same bits" and not text.startswith("NOT RUN")
        print(f"{platform.name:18} {law:9} {text}", flush=True)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
