"""The command line ``wmr-ctrl``: parse, call, print.

Nothing heavier than click is imported before a command runs.
"""

from wmr_ctrl.cli.root import main as main
from wmr_ctrl.cli.root import root as root
