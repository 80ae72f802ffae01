"""From a log to a scenario: parameters with intervals, and bounds for guard or filter."""

from .bounds import BaseIdentification as BaseIdentification
from .identification import Identification as Identification
from .identification import identify as identify
