"""Predictions before a run: checks, linear models, and the door to corridor and proofs."""
