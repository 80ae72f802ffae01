"""Gains of a law for a scenario, found by search on runs."""

from wmr_ctrl.tuning.gains import Tuning as Tuning
from wmr_ctrl.tuning.gains import judged as judged
from wmr_ctrl.tuning.gains import tune as tune
from wmr_ctrl.tuning.search import tunable as tunable
