"""C code from graphs: kernels, packages for microcontrollers, compiler and cache."""
