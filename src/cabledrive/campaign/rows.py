"""The rows of a chunk: values of the keys, status, reason, seed and time of each, and the outputs."""

import time
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from cabledrive.campaign.computation import FLAG, TEXT, Found, Output, Row
from cabledrive.campaign.keys import COMPUTE, DRIVE, GOALS, MOTION, OWN, PLANT, drive_with, settings_of
from cabledrive.campaign.spec import CampaignSpec
from cabledrive.parameters import InputRefused, NotComputed

DONE, DEFECT, REFUSED, FAILED, NOT_YET = 0, 1, 2, 3, -1
"""Status of a row, as the exit status of a command; a defect of the package ends its row alone."""
UNKNOWN = -1
"""Of a flag that has not been found."""
POISONED = "the process ended while this row was computed, twice alone: {why}"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Chunk:
    """What the rows of a chunk gave."""

    variables: dict[str, NDArray[Any]]
    """Varied keys and outputs, each (rows, ...); without a value NaN, empty or `UNKNOWN`."""
    code: NDArray[np.int8]  # (rows,)
    reason: NDArray[Any]  # (rows,)
    seed: NDArray[np.uint64]  # (rows,)
    time: NDArray[np.float64]  # (rows,) [s]


@runtime_checkable
class ManyRows(Protocol):
    """A computation that does many rows at once, each to the same number as alone."""

    def many(
        self, spec: CampaignSpec, values: Mapping[str, NDArray[Any]]
    ) -> tuple[NDArray[np.bool_], dict[str, NDArray[Any]]] | None:
        """Which rows fit and are done, and their outputs; None: no campaign for this. Values in SI."""
        ...


def row_seeds(seed: int, first: int, last: int) -> NDArray[np.uint64]:
    """A seed for each row, below 2^53, the same however rows are divided: SplitMix64 of seed and row."""
    with np.errstate(over="ignore"):
        z = np.arange(first, last, dtype=np.uint64) + np.uint64(1)
        z = z * np.uint64(0x9E3779B97F4A7C15) + np.uint64(seed % 2**64) * np.uint64(0xD1B54A32D192ED03)
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.asarray((z ^ (z >> np.uint64(31))) >> np.uint64(11))


def empty(output: Output, rows: int) -> NDArray[Any]:
    """An output before it is known, shape (rows, ...)."""
    shape = (rows, *output.shape)
    if output.kind == TEXT:
        return np.full(shape, "", dtype=object)
    if output.kind == FLAG:
        return np.full(shape, UNKNOWN, dtype=np.int8)
    return np.full(shape, np.nan)


def compute_rows(
    spec: CampaignSpec,
    first: int,
    last: int,
    *,
    poisoned: Mapping[int, str] | None = None,
    begin: Callable[[int], None] | None = None,
    at_once: bool = True,
) -> Chunk:
    """Compute some rows; each depends on the SPEC and its own number alone.

    ``poisoned``: why a row is not tried, by its number; ``begin``: called before each row with its number;
    ``at_once``: whether many rows may be computed in one call.
    """
    count, poisoned = last - first, poisoned or {}
    values, seeds = spec.values(first, last), row_seeds(spec.seed, first, last)
    outputs = {output.name: empty(output, count) for output in spec.computation.outputs}
    code, times = np.full(count, DONE, dtype=np.int8), np.zeros(count)
    reason = np.full(count, "", dtype=object)
    done: NDArray[np.bool_] = np.zeros(count, dtype=bool)
    if at_once and isinstance(spec.computation, ManyRows):
        sound = np.array([row not in poisoned for row in range(first, last)])
        began = time.perf_counter()
        found = spec.computation.many(spec, {key: column[sound] for key, column in values.items()})
        if found is not None:
            done[sound], columns = found
            for name in outputs:
                outputs[name][done] = columns[name][done[sound]]
            times[done] = (time.perf_counter() - began) / count
    for i in np.flatnonzero(~done):
        row = first + int(i)
        if row in poisoned:
            code[i], reason[i] = FAILED, POISONED.format(why=poisoned[row])
            continue
        if begin is not None:
            begin(row)
        began = time.perf_counter()
        given, code[i], reason[i] = _one(
            spec, {key: column[i] for key, column in values.items()}, int(seeds[i])
        )
        times[i] = time.perf_counter() - began
        for name in given.keys() & outputs.keys():
            outputs[name][i] = _stored(given[name], outputs[name].dtype)
    return Chunk(variables=values | outputs, code=code, reason=reason, seed=seeds, time=times)


def _stored(value: Any, dtype: Any) -> Any:
    """A value as its array takes it: an unknown flag is `UNKNOWN`, an unknown number NaN."""
    if value is None:
        return "" if dtype.kind == "O" else UNKNOWN if dtype.kind == "i" else np.nan
    return value


def _one(spec: CampaignSpec, values: Mapping[str, Any], seed: int) -> tuple[Mapping[str, Any], int, str]:
    """Outputs, status and reason of one row."""
    try:
        with np.errstate(all="ignore"):
            found = spec.computation.one(row_of(spec, values, seed))
    except InputRefused as refusal:
        return {}, REFUSED, str(refusal)
    except NotComputed as failure:
        return {}, FAILED, str(failure)
    except (ArithmeticError, ValueError, TypeError, LookupError, AttributeError, AssertionError) as defect:
        return {}, DEFECT, f"a defect of cabledrive, {type(defect).__name__}: {defect}"
    if isinstance(found, Found):
        return found.values, FAILED, found.incomplete
    return found, DONE, ""


def row_of(spec: CampaignSpec, values: Mapping[str, Any], seed: int) -> Row:
    """One row as its computation gets it. Raises `InputRefused` if its values make no drive."""
    plain = {key: _plain(value, spec.units.get(key, "1")) for key, value in values.items()}
    name = plain.get(DRIVE, next(iter(spec.drives)))
    settings, plant = settings_of(plain, ""), settings_of(plain, PLANT)
    base, tables = spec.drives[name], spec.tables[name]
    options = getattr(spec.computation, "options", {})
    return Row(
        drive=drive_with(base, tables, settings),
        plant=drive_with(base, tables, settings | plant) if plant else None,
        motion=dict(spec.motion) | settings_of(plain, MOTION),
        goals=dict(spec.goals) | settings_of(plain, GOALS),
        options=options | settings_of(plain, COMPUTE),
        own=settings_of(plain, OWN),
        seed=seed,
    )


def _plain(value: Any, unit: str) -> Any:
    """A value as a drive file has it: a number, a whole number, a word, true or false."""
    if not unit:
        return bool(value) if isinstance(value, (bool, np.bool_)) else str(value)
    return int(value) if unit == "count" and float(value).is_integer() else float(value)


def counts(code: NDArray[np.int8]) -> dict[str, int]:
    """Rows done, refused and failed, of a list of status."""
    done: Collection[int] = np.bincount(code[code >= 0], minlength=FAILED + 1).tolist()
    by_code = list(done)
    return {"done": sum(by_code), "refused": by_code[REFUSED], "failed": by_code[FAILED] + by_code[DEFECT]}
