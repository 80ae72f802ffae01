"""Co-simulation of FMUs, ours or somebody else's, into a Run."""

from wmr_ctrl.export.cosim.run import cosimulate as cosimulate
