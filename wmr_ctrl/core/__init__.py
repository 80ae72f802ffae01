"""Vocabulary of all rooms: fields of a scenario, signals, units, errors, the paper as data."""
