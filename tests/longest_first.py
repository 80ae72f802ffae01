"""Which tests the processes take first: the longest, so that none of them ends long after the rest.

long_ones.txt tells what takes long. It is a matter of time alone: any order gives the same results.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path

from xdist.scheduler import LoadScopeScheduling

LIST = Path(__file__).with_name("long_ones.txt")


class Apart(LoadScopeScheduling):
    """The tests of a file stay together, but for long functions: each case is a job of its own.

    Of a folder that is listed as such all tests stay together.
    """

    def _split_scope(self, nodeid: str) -> str:
        return job(nodeid)


def job(nodeid: str) -> str:
    """What is given to one process as a whole: a case of a long function, or a folder or a file."""
    file = nodeid.partition("::")[0]
    folder = file.rpartition("/")[0]
    if function_of(nodeid) in long_ones():
        return nodeid
    return folder if folder in long_ones() and file not in long_ones() else file


def function_of(nodeid: str) -> str:
    """The test without its case."""
    return nodeid.partition("[")[0]


def seconds(nodeid: str) -> float:
    """How long the job of a test takes, by the list."""
    return long_ones().get(function_of(job(nodeid)), 0.0)


@cache
def long_ones() -> Mapping[str, float]:
    """By function the seconds of one case, by file or folder those of all that is not listed."""
    rows = (line.split() for line in LIST.read_text(encoding="utf-8").splitlines())
    return {row[1]: float(row[0]) for row in rows if row and row[0] != "#"}
