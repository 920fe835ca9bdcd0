"""The rows of a chunk: values of the keys, status, reason, seed and time of each, and the outputs."""

import time
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.campaign.computation import FLAG, NUMBER, TEXT, Found, Row
from cabledrive.campaign.spec import COMPUTE, DRIVE, GOALS, MOTION, OWN, PLANT, CampaignSpec, settings_of
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.keys import varied_together
from cabledrive.parameters.toml_values import whole_of

DONE, DEFECT, REFUSED, FAILED, NOT_YET = 0, 1, 2, 3, -1
"""Status of a row, as the exit status of a command; a defect of the package ends its row alone."""
WORDS = {
    DONE: "done",
    DEFECT: "defect",
    REFUSED: "refused",
    FAILED: "not completed",
    NOT_YET: "not yet computed",
}
MEANINGS = ", ".join(f"{status} {word}" for status, word in WORDS.items())
UNKNOWN = -1
"""Of a flag that has not been found."""
STATUS = "code"
BESIDE: dict[str, tuple[Any, Any, dict[str, str]]] = {
    STATUS: (np.int8, NOT_YET, {"long_name": f"status of the row: {MEANINGS}"}),
    "reason": (str, "", {"long_name": "why the row is not done, in one line"}),
    "seed": (np.uint64, 0, {"long_name": "seed of the row's random numbers"}),
    "time": (np.float64, np.nan, {"long_name": "time that the row took", "units": "s"}),
}
"""Variables that are neither keys nor outputs: type, what stands where a row is not done, attributes."""
LOST = "the process ended while this row was computed, twice alone: {why}"


Chunk = dict[str, NDArray[Any]]
"""What rows gave: varied keys and outputs by name, each (rows, ...), and code, reason, seed, time [s]."""


def row_seeds(seed: int, first: int, last: int) -> NDArray[np.uint64]:
    """A seed for each row, below 2^53, the same however rows are divided: SplitMix64 of seed and row."""
    with np.errstate(over="ignore"):
        z = np.arange(first, last, dtype=np.uint64) + np.uint64(1)
        z = z * np.uint64(0x9E3779B97F4A7C15) + np.uint64(seed % 2**64) * np.uint64(0xD1B54A32D192ED03)
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.asarray((z ^ (z >> np.uint64(31))) >> np.uint64(11))


STORED: dict[str, tuple[Any, Any]] = {NUMBER: (np.float64, np.nan), FLAG: (np.int8, UNKNOWN), TEXT: (str, "")}
"""Type of a variable by its kind, and what stands where nothing is known."""


def compute_rows(spec: CampaignSpec, first: int, last: int) -> Chunk:
    """Compute some rows; each depends on the SPEC and its own number alone."""
    values, outputs, chunk = _begun(spec, first, last)
    done: NDArray[np.bool_] = np.zeros(last - first, dtype=bool)
    began = time.perf_counter()
    many = getattr(spec.computation, "many", None)
    found = many and many(spec, values)
    if found:
        done, columns = found
        for name in outputs:
            outputs[name][done] = columns[name][done]
        chunk["time"][done] = (time.perf_counter() - began) / done.size
    for i in np.flatnonzero(~done):
        began = time.perf_counter()
        row = {key: column[i] for key, column in values.items()}
        given, chunk["code"][i], chunk["reason"][i] = _one(spec, row, int(chunk["seed"][i]))
        chunk["time"][i] = time.perf_counter() - began
        for output in spec.computation.outputs:
            value = given.get(output.name)
            if value is not None:
                outputs[output.name][i] = value
    return chunk


def _begun(spec: CampaignSpec, first: int, last: int) -> tuple[Chunk, Chunk, Chunk]:
    """Values of the keys and outputs by name, and the chunk that holds them, before anything is computed."""

    def column(dtype: Any, fill: Any, shape: tuple[int, ...] = ()) -> NDArray[Any]:
        return np.full((last - first, *shape), fill, dtype=object if dtype is str else dtype)

    values = spec.values(first, last)
    outputs = {one.name: column(*STORED[one.kind], one.shape) for one in spec.computation.outputs}
    about = {name: column(dtype, fill) for name, (dtype, fill, _) in BESIDE.items()}
    about[STATUS][:], about["seed"][:], about["time"][:] = DONE, row_seeds(spec.seed, first, last), 0.0
    return values, outputs, values | outputs | about


def lost_row(spec: CampaignSpec, row: int, why: str) -> Chunk:
    """A row that ended its process each time it was computed."""
    *_, chunk = _begun(spec, row, row + 1)
    chunk["code"][0], chunk["reason"][0] = FAILED, LOST.format(why=why)
    return chunk


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
    plain = {key: plain_value(value, spec.units.get(key, "1")) for key, value in values.items()}
    for key, value in plain.items():
        if spec.units.get(key) == "count" and key.startswith((f"{MOTION}.", f"{GOALS}.", f"{COMPUTE}.")):
            whole_of(key, value)
    name = plain.get(DRIVE, next(iter(spec.drives)))
    settings, plant = settings_of(plain, ""), settings_of(plain, PLANT)
    base = spec.drives[name]
    options = getattr(spec.computation, "options", {})
    return Row(
        drive=varied_together(base, settings),
        plant=varied_together(base, settings | plant) if plant else None,
        motion=dict(spec.motion) | settings_of(plain, MOTION),
        goals=dict(spec.goals) | settings_of(plain, GOALS),
        options=options | settings_of(plain, COMPUTE),
        own=settings_of(plain, OWN),
        seed=seed,
    )


def plain_value(value: Any, unit: str) -> Any:
    """A value as a drive file has it: a number, a whole number, a word, true or false."""
    if not unit:
        return bool(value) if isinstance(value, (bool, np.bool_)) else str(value)
    return int(value) if unit == "count" and float(value).is_integer() else float(value)


def counts(code: NDArray[np.int8]) -> dict[str, int]:
    """Rows done, refused and failed, of a list of status."""
    by_code = [int(count) for count in np.bincount(code[code >= 0], minlength=FAILED + 1)]
    return {"done": sum(by_code), "refused": by_code[REFUSED], "failed": by_code[FAILED] + by_code[DEFECT]}
