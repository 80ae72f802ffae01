"""From a log to a scenario: parameters with intervals, and bounds for guard or filter."""

from wmr_ctrl.identification.bounds import BaseIdentification as BaseIdentification
from wmr_ctrl.identification.identification import Identification as Identification
from wmr_ctrl.identification.identification import identify as identify
