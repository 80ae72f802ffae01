"""From a System to compiled C: kernels and manifest, C compiler, build cache."""
