"""Compiled kernels. Importing one of these modules imports numba."""
