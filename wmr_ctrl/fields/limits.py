"""Sizes past which input is refused before anything is counted or unpacked."""

SEED_END = 2**63
"""Seeds are whole numbers from 0 up, below this."""
MOST_SEEDS = 10_000_000
"""Runs that one call may be asked for."""
MOST_JOBS = 4096
"""Threads or processes that one call may be asked for."""
MOST_NODES = 200_000
"""Values of a YAML file, each alias counted as often as it would be written out."""
MOST_UNPACKED, RATIO = 200_000_000, 100
"""Bytes that a packed file may hold unpacked, or so many times its own size if that is more."""


def may_unpack(packed: int, unpacked: int) -> bool:
    """True if so many bytes may be unpacked to so many."""
    return unpacked <= max(MOST_UNPACKED, RATIO * packed)
