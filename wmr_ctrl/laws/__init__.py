"""Control laws: one file each, listed in `registry.NAMES`."""

from wmr_ctrl.laws.registry import LAWS as LAWS
