"""Co-simulation of FMUs, ours or somebody else's, into a Run."""

from .run import cosimulate as cosimulate
