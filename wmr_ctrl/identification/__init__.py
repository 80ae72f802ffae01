"""From a log to a scenario: parameters of a robot with intervals, and a guard's numbers."""

from wmr_ctrl.identification.bounds import BaseIdentification as BaseIdentification
from wmr_ctrl.identification.identification import Identification as Identification
from wmr_ctrl.identification.identification import identify as identify
