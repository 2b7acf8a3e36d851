"""The only place that knows how numba compiles."""
