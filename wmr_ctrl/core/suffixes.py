"""Suffixes of the files in which runs are saved: the one list, which loads nothing."""

BAG = ".mcap"
RUNS = (".npz", ".csv", BAG)
"""Suffixes of runs; all but a bag are read back as runs, by `results/formats.py`."""
RUN_FILE = ".npz or .csv"
"""Text with the suffixes that are read back."""
