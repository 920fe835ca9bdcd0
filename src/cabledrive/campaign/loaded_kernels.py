"""Loads numba with what it looks for at its first kernel, in the process that workers are forked from."""

from contextlib import suppress

from cabledrive.mechanics.compiled import numba_at_hand

if numba_at_hand():
    with suppress(Exception):  # of numba's inside: without it the first kernel of each worker takes longer
        from numba.core.registry import cpu_target

        import cabledrive.mechanics.kernel_cache  # noqa: F401

        cpu_target.target_context.refresh()
