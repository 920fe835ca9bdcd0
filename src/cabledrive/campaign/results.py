"""A store read again: values of keys and outputs row by row, with units, and what became of each row."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.campaign.rows import DONE, REFUSED
from cabledrive.campaign.store import STATUS, attributes_of, zarr_at_hand
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import nearest

BESIDE = (STATUS, "reason", "seed", "time")
"""Variables that are neither keys nor outputs."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Results:
    """A store."""

    path: Path
    attributes: dict[str, Any]  # what the store says of itself
    group: Any
    code: NDArray[np.int8]  # (rows,): status

    @property
    def keys(self) -> tuple[str, ...]:
        """Varied keys that are numbers."""
        return tuple(key for key in self.attributes["varied"] if self.group[key].dtype.kind == "f")

    @property
    def outputs(self) -> dict[str, tuple[int, ...]]:
        """Outputs that are numbers or flags, with the shape of a row."""
        others = {*self.attributes["varied"], *BESIDE}
        return {
            name: array.shape[1:]
            for name, array in self.group.arrays()
            if name not in others and array.dtype.kind in "fi"
        }

    def unit(self, name: str) -> str:
        """SI unit of a variable; "1" of flags."""
        return str(self.group[name.partition("[")[0]].attrs.get("units", "1"))

    def key(self, name: str) -> Array:
        """Values of a key, shape (rows,), in SI."""
        return np.asarray(self.group[name][:], dtype=float)

    def output(self, name: str) -> Array:
        """Values of an output such as ``longitudinal_hz[0]``, (rows,), NaN: none; others are refused."""
        found = re.fullmatch(r"(\w+)((?:\[\d{1,6}\])*)", name.replace(" ", ""))
        known = self.outputs
        word = found[1] if found else name[:60]
        if found is None or word not in known:
            raise InputRefused(f'"{word}" is no number of this store{nearest(word, known)}')
        place = tuple(int(number) for number in re.findall(r"\d+", found[2]))
        shape = known[word]
        if len(place) != len(shape) or any(i >= n for i, n in zip(place, shape, strict=True)):
            example = word + "".join("[0]" for _ in shape)
            sizes = " x ".join(map(str, shape)) or "one number"
            raise InputRefused(f'"{name[:60]}": each row has {sizes}: write, for instance, {example}')
        values = np.asarray(self.group[word][(slice(None), *place)], dtype=float)
        return np.where(values < 0.0, np.nan, values) if self.group[word].dtype.kind == "i" else values

    @property
    def counts(self) -> dict[str, int]:
        """Rows in all, with a status, refused, and not completed."""
        return {
            "rows": int(self.code.size),
            "done": int(np.count_nonzero(self.code >= 0)),
            "refused": int(np.count_nonzero(self.code == REFUSED)),
            "failed": int(np.count_nonzero((self.code > DONE) & (self.code != REFUSED))),
        }


def open_results(path: str | Path) -> Results:
    """Open the store of a campaign to read. Raises `InputRefused` if it is none, or no row of it is done."""
    path = Path(path)
    attributes = attributes_of(path)
    group = zarr_at_hand().open_group(str(path), mode="r")
    code = np.asarray(group[STATUS][:])
    if not np.any(code >= 0):
        raise InputRefused("no row is done yet: run the sweep first").at(str(path))
    return Results(path=path, attributes=attributes, group=group, code=code)
