"""Words that every room uses: fields of a scenario, signals, units, errors, the paper as data."""
