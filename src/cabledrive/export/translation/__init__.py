"""Kernels to C99: a small closed subset of Python, specialised to the shapes of one design."""
