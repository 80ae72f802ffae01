"""Co-simulation of FMUs, ours or somebody else's, into a Run."""

from wmr_ctrl.fmi.cosim.run import cosimulate as cosimulate
