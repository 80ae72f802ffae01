"""Engine of the certified corridor, in ball arithmetic."""
