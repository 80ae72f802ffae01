"""Logs of robots: columns read in SI units, samples of the motion, and named faults."""
