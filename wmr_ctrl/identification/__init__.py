"""From a log to a scenario: parameters of a robot with intervals, and what a guard may count on."""

from __future__ import annotations

from wmr_ctrl.identification.bounds import BaseIdentification as BaseIdentification
from wmr_ctrl.identification.identification import Identification as Identification
from wmr_ctrl.identification.identification import identify as identify
