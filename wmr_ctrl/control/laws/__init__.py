"""Control laws: one file each, listed in `registry.NAMES`."""

from .registry import LAWS as LAWS
