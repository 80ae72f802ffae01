"""Fields of scenarios, errors, signals and what else every room needs."""
