"""The paper as data: its numbered equations, its symbols, how to cite it."""

from __future__ import annotations

from wmr_ctrl.paper.citation import CITATION as CITATION
from wmr_ctrl.paper.equations import Equation as Equation
from wmr_ctrl.paper.equations import equation as equation
from wmr_ctrl.paper.equations import equations as equations
from wmr_ctrl.paper.symbols import Symbol as Symbol
from wmr_ctrl.paper.symbols import symbols as symbols
