"""Logs that do not fit into memory, block by block."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def overlapping(
    blocks: Iterator[dict[str, Array]], reach: int
) -> Iterator[tuple[dict[str, Array], int, int]]:
    """Blocks of a long log, each with what lies before and after it, so that filters settle.

    Parameters
    ----------
    blocks : iterator of dict of str to ndarray
    reach : int
        Samples of overlap on either side.

    Yields
    ------
    block : dict of str to ndarray
    start, end : int
        Part of it that belongs to no other block.
    """
    held: dict[str, Array] = {}
    start = 0
    for block in blocks:
        joint = (
            {name: np.concatenate([held[name], values]) for name, values in block.items()} if held else block
        )
        size = next(iter(joint.values())).size
        if size <= start + 2 * reach:
            held = joint
            continue
        yield joint, start, size - reach
        held = {name: values[size - 2 * reach :] for name, values in joint.items()}
        start = reach
    if held:
        size = next(iter(held.values())).size
        if size > start:
            yield held, start, size
