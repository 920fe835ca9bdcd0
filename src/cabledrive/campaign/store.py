"""The store of a campaign: one labelled Zarr group, each chunk of rows written by one worker.

Chunks of work are the chunks of every array, so that no two processes write one file. The status of the rows
is written last, when the rows are on the disk: a chunk whose status can be read is done, whatever killed
whom.
"""

import json
import os
import platform
import shutil
import tempfile
import warnings
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.campaign.computation import FLAG, NUMBER, TEXT, Output
from cabledrive.campaign.rows import BESIDE, NOT_YET, STATUS, STORED, UNKNOWN, Chunk, counts
from cabledrive.campaign.spec import CampaignSpec
from cabledrive.parameters import InputRefused, drive_text
from cabledrive.parameters.files import sync_folder, umask
from cabledrive.parameters.version import __version__

AT_ONCE = 8
"""Files that wait for the disk at a time."""
FORMAT = 1
CAMPAIGN = "cabledrive_campaign"
EXTRA = "campaigns need an extra: pip install 'cabledrive[campaign]'"


def sync_chunk(store: Path, names: Iterable[str], number: int) -> None:
    """Bring a chunk of some arrays to the disk; one that holds nothing but its fill value has no file.

    All files at once, since the disk then writes its journal once for many of them.
    """
    files: list[Path] = []
    folders: set[Path] = set()
    for name in names:
        place = store / name / "c" / str(number)
        found = [path for path in (place.rglob("*") if place.is_dir() else [place]) if path.is_file()]
        files += found
        folders |= {store / name / "c", *(path.parent for path in found)}
    with ThreadPoolExecutor(AT_ONCE) as pool:
        list(pool.map(_sync, files))
        list(pool.map(sync_folder, folders))


def _sync(path: Path) -> None:
    with path.open("rb") as file:
        os.fsync(file.fileno())


def zarr_at_hand() -> Any:
    """The library of the store. Raises `InputRefused` if it is not installed."""
    try:
        import zarr
    except ImportError:
        raise InputRefused(EXTRA) from None
    return zarr


def create(path: Path, spec: CampaignSpec, chunk: int) -> None:
    """Make an empty store of chunks of some rows, whole or not at all; another may have been faster."""
    folder = Path(tempfile.mkdtemp(dir=path.parent, prefix=f".{path.name}-"))
    try:
        _fill(folder, spec, chunk)
        for made in [*folder.rglob("*"), folder]:
            (sync_folder if made.is_dir() else _sync)(made)
        os.chmod(folder, 0o777 & ~umask())
        with suppress(OSError):  # it is there by now: the caller looks whose it is
            os.rename(folder, path)
            sync_folder(path.parent)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _fill(folder: Path, spec: CampaignSpec, chunk: int) -> None:
    zarr, rows = zarr_at_hand(), spec.design.rows
    group = zarr.open_group(str(folder), mode="w", zarr_format=3)
    group.attrs.update(
        {
            "title": "campaign of cabledrive",
            CAMPAIGN: FORMAT,
            "cabledrive": __version__,
            "campaign": spec.identity,
            "chunk": chunk,
            "rows": rows,
            "drives": {name: drive_text(drive) for name, drive in spec.drives.items()},
            "varied": list(spec.units),
            "axes": [list(axis.units) for axis in spec.axes],
            "environment": {  # what the last digits of results may depend on
                "machine": platform.machine(),
                "python": platform.python_version(),
                **{name: version(name) for name in ("numpy", "scipy", "numba")},
            },
        }
    )
    variables = (*_keys(spec), *spec.computation.outputs)
    arrays = [
        (one.name, one.shape, one.dims, *STORED[one.kind], _attributes(one, varied=one.name in spec.units))
        for one in variables
    ]
    arrays += [(name, (), (), *stated) for name, stated in BESIDE.items()]
    for name, shape, dims, dtype, fill, words in arrays:
        group.create_array(
            name,
            shape=(rows, *shape),
            chunks=(min(chunk, rows), *shape),
            dtype=dtype,
            fill_value=fill,
            dimension_names=("row", *dims),
            attributes=words,
        )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the consolidated copy of the metadata is an extension of Zarr 3
        zarr.consolidate_metadata(str(folder))


def _keys(spec: CampaignSpec) -> list[Output]:
    """The keys that are varied, described as outputs are."""
    first = spec.values(0, 1)
    kind = {True: FLAG, False: TEXT}
    return [
        Output(name=key, unit=unit, meaning=key, kind=NUMBER if unit else kind[first[key].dtype == bool])
        for key, unit in spec.units.items()
    ]


def _attributes(one: Output, *, varied: bool) -> dict[str, Any]:
    """Name, and unit or meanings of the values, as the conventions of climate and forecast data have them."""
    found: dict[str, Any] = {"long_name": one.meaning}
    if one.kind == NUMBER:
        found["units"] = "1" if one.unit == "count" else one.unit
    elif one.kind == FLAG:
        found |= {"flag_meanings": "unknown no yes", "flag_values": [UNKNOWN, 0, 1]}
    return found | ({"varied": 1} if varied else {})


def check_store(path: Path, spec: CampaignSpec) -> int:
    """Rows of a chunk of a store, refused with the differing key if another campaign or version began it."""
    attributes = attributes_of(path)
    if attributes.get("cabledrive") != __version__:
        raise InputRefused(
            f"was begun by cabledrive {attributes.get('cabledrive')}, this is {__version__}: use that "
            "version, or choose another name"
        ).at(str(path))
    ours, theirs = json.loads(json.dumps(spec.identity)), attributes["campaign"]
    for key in ours | theirs:
        if ours.get(key) != theirs.get(key):
            raise InputRefused(
                f"holds another campaign: {key} = {_short(theirs.get(key))} there, "
                f"{_short(ours.get(key))} in the SPEC: choose another name"
            ).at(str(path))
    chunk: int = attributes["chunk"]
    if spec.chunk is not None and spec.chunk != chunk:
        raise InputRefused(
            f"compute.chunk = {spec.chunk}, but the store was begun with {chunk}: leave chunk out"
        ).at(str(path))
    return chunk


def attributes_of(path: Path) -> dict[str, Any]:
    """What a store says of itself; refused if it is no store of a campaign, or of another version."""
    zarr = zarr_at_hand()
    if not (path / "zarr.json").is_file():
        raise InputRefused("is no store of a campaign: give the STORE.zarr of a sweep").at(str(path))
    try:
        attributes = dict(zarr.open_group(str(path), mode="r").attrs)
    except Exception as error:  # whatever another program left there
        raise InputRefused(f"cannot be read as Zarr ({type(error).__name__}): choose another").at(
            str(path)
        ) from None
    if attributes.get(CAMPAIGN) != FORMAT:
        raise InputRefused(
            f"is no store of this format (version {attributes.get(CAMPAIGN, 'unknown')}, needed {FORMAT}): "
            "choose another name"
        ).at(str(path))
    return attributes


def delete_another(path: Path, spec: CampaignSpec) -> None:
    """Delete a store that is not of this campaign, so that it can begin anew; what is no store is kept."""
    if not (path / "zarr.json").is_file():
        return
    try:
        if CAMPAIGN in zarr_at_hand().open_group(str(path), mode="r").attrs:
            check_store(path, spec)
    except InputRefused:
        shutil.rmtree(path)


def _short(value: Any) -> str:
    text = "nothing" if value is None else json.dumps(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def done_chunks(path: Path) -> set[int]:
    """Numbers of the chunks that are done; a status that a loss of power has damaged is deleted."""
    array, done = open_arrays(path)[STATUS], set[int]()
    for file in (path / STATUS / "c").glob("*"):
        if file.name.isdecimal():
            try:
                whole = not np.any(array.blocks[int(file.name)] == NOT_YET)  # one for each row
            except Exception:  # whatever a damaged file does to its decoder
                whole = False
            if whole:
                done.add(int(file.name))
            else:
                file.unlink(missing_ok=True)
    return done


@lru_cache(maxsize=4)
def _arrays(path: Path, made: int) -> dict[str, Any]:
    """Arrays of a store by name; ``made``: when, another moment where it was made anew."""
    group = zarr_at_hand().open_group(str(path), mode="r+")
    return {name: group[name] for name in group.array_keys()}


def open_arrays(path: Path) -> dict[str, Any]:
    """Arrays of a store by name, opened once in a process."""
    return _arrays(path, (path / "zarr.json").stat().st_mtime_ns)


def write_chunk(path: Path, first: int, chunk: Chunk) -> dict[str, int]:
    """Write rows, their status last, when they are on the disk; `OSError` if it refuses. Returns `counts`."""
    arrays, status = open_arrays(path), chunk[STATUS]
    number, rows = first // arrays[STATUS].chunks[0], slice(first, first + status.size)
    names = [name for name in chunk if name != STATUS]
    for name in names:
        values = chunk[name]
        arrays[name][rows] = values.astype(np.int8) if values.dtype == bool else values
    sync_chunk(path, names, number)
    arrays[STATUS][rows] = status
    sync_chunk(path, [STATUS], number)
    return counts(status)


def status_counts(path: Path) -> dict[str, Any]:
    """Rows done, refused and failed so far, and why the first of these has no result."""
    arrays = open_arrays(path)
    code = arrays[STATUS][:]
    bad = np.flatnonzero(code > 0)
    return counts(code) | {"first_reason": str(arrays["reason"][bad[0]]) if bad.size else ""}
