"""Computation of the certified corridor, in ball arithmetic."""
