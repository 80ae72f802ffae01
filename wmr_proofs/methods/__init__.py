"""Methods of proof: exact algebra, z3, ball arithmetic, and refutation by exact points."""
