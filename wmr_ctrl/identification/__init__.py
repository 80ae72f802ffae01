"""Identify a robot from a log: parameters with intervals, bounds for guard or filter."""

from .bounds import BaseIdentification as BaseIdentification
from .identification import Identification as Identification
from .identification import identify as identify
