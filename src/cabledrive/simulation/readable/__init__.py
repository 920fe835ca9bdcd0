"""Readable twins of the compiled kernels, in numpy: their oracle, and what runs where numba is absent."""
