"""The panels of the paper's Figs. 3 and 5, each a function that draws runs of several laws."""

from wmr_ctrl.report.panels.base import Group, Panel
from wmr_ctrl.report.panels.catalogue import PANELS

__all__ = ["PANELS", "Group", "Panel"]
