"""Suffixes of the files in which runs are saved: the one list, which loads nothing."""

RUNS = (".npz", ".csv", ".mcap")
"""`results/formats.py` has the writer and the reader of each, in this order."""
RUN_FILE = f"{', '.join(RUNS[:-1])} or {RUNS[-1]}"
"""The same as words."""
