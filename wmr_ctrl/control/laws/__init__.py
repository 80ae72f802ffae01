"""Control laws: one file each, listed in `registry.NAMES`."""

from wmr_ctrl.control.laws.registry import LAWS as LAWS
