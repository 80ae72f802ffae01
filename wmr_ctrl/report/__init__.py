"""Figures, tables, verdicts and the one-page report; single runs as a picture or an animation.

Nothing is imported here, since matplotlib is slow to load: see :mod:`wmr_ctrl.report.write`,
:mod:`wmr_ctrl.report.plot_run` and :mod:`wmr_ctrl.report.animate`.
"""
