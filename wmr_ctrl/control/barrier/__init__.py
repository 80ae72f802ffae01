"""The barrier Lyapunov function: as printed, free of cancellation, smooth, and its proximal map."""
