"""Logs of robots: columns read in SI units, samples of the motion, and faults told by name."""
