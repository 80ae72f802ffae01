"""The section past the paper: every law with and without the guard."""

from wmr_ctrl.report.ours.data_file import write_ours
from wmr_ctrl.report.ours.figures import our_figures
from wmr_ctrl.report.ours.section import our_section

__all__ = ["our_figures", "our_section", "write_ours"]
