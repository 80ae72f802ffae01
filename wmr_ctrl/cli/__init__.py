"""The command line `wmr-ctrl`: parse, call, print."""

from .root import main as main
from .root import root as root
