"""Gains of a law for a scenario, found by a search over runs."""

from .gains import Tuning as Tuning
from .gains import judged as judged
from .gains import tune as tune
from .search import tunable as tunable
