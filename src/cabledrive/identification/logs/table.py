"""What every log format looks like from inside: named columns that are read in blocks."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import InputRefused
from cabledrive.parameters.fields import nearest

Array = NDArray[np.float64]
Blocks = Iterator[dict[str, Array]]

BLOCK_ROWS = 1 << 20
LARGEST_UNPACKED = 16 * 2**30
"""Bytes that the columns of one compressed file may unpack to; more is refused as a possible bomb."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """Columns of a log file.

    Attributes
    ----------
    source : str
        Name of the file.
    names : tuple of str
        Columns, as the file calls them.
    units : dict of str to str
        Units that the file states, by column.
    rows : int or None
        Number of rows; None where only reading tells.
    read : callable
        ``read(names)`` yields blocks of equal columns; a missing value is NaN.
    scalars : dict of str to float
        Single numbers in the file, such as a drive gain.
    """

    source: str
    names: tuple[str, ...]
    units: dict[str, str]
    rows: int | None
    read: Callable[[tuple[str, ...]], Blocks]
    scalars: dict[str, float] = field(default_factory=dict)

    def require(self, name: str) -> str:
        """Refuse a column that is not there.

        Parameters
        ----------
        name : str

        Returns
        -------
        str
            The name itself.

        Raises
        ------
        InputRefused
            With the nearest column that is there.
        """
        if name not in self.names:
            raise InputRefused(f'{self.source}: no column "{name}"{nearest(name, self.names)}')
        return name


def check_lengths(lengths: Mapping[str, int], source: str) -> None:
    """Refuse columns of different lengths.

    Parameters
    ----------
    lengths : mapping of str to int
        By column.
    source : str
        Name of the file.

    Raises
    ------
    InputRefused
        If they differ.
    """
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise InputRefused(f"{source}: channels differ in length ({told}): choose channels of one length")


def sliced(columns: dict[str, Array], rows: int = BLOCK_ROWS) -> Blocks:
    """Columns in memory as blocks.

    Parameters
    ----------
    columns : dict of str to ndarray
        Equally long.
    rows : int
        Rows per block.

    Yields
    ------
    dict of str to ndarray
    """
    length = len(next(iter(columns.values()), ()))
    for start in range(0, length, rows):
        yield {name: values[start : start + rows] for name, values in columns.items()}


def numbers(values: object, name: str, source: str) -> Array:
    """A column as floats.

    Parameters
    ----------
    values : array-like
    name, source : str
        For the refusal.

    Returns
    -------
    ndarray

    Raises
    ------
    InputRefused
        If it holds something else than real numbers.
    """
    array = np.asarray(values)
    if array.dtype.kind not in "fiub":
        raise InputRefused(
            f'{source}: column "{name}" holds {array.dtype}, not real numbers: choose another column'
        )
    return array.astype(float, copy=False)
