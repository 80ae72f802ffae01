"""From graphs to C: kernels, packages for microcontrollers, compiler and cache."""
