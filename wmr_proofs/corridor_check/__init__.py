"""Checker of the certified corridor, which shares no code with its computation."""
