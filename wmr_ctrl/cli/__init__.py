"""The command line `wmr-ctrl`: parse, call, print."""

from wmr_ctrl.cli.root import main as main
from wmr_ctrl.cli.root import root as root
