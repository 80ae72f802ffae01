"""Gains of a law for a scenario, found by search on runs."""

from wmr_ctrl.simulation.tuning.gains import Tuning as Tuning
from wmr_ctrl.simulation.tuning.gains import judged as judged
from wmr_ctrl.simulation.tuning.gains import tune as tune
from wmr_ctrl.simulation.tuning.search import tunable as tunable
