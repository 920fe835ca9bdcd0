"""The SPEC of a campaign: drives, what is varied and how, what is computed for each row."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.campaign.computation import (
    Computation,
    NamedComputation,
    check_required,
    kinds,
    named_computation,
)
from cabledrive.campaign.design import Design, design_of
from cabledrive.campaign.keys import DRIVE, MOTION_UNITS, goal_units, unit_of
from cabledrive.campaign.vary import Axis, axes_of, varied_keys
from cabledrive.parameters import Drive, InputRefused, content_hash, load_drive
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import described, meaning, require_known
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.toml_values import quantity_of, read_toml, table_of, text_of, whole_of

TABLES = ("drive", "vary", "design", "compute", "motion", "goals")
AUTO = "auto"


@described
@dataclass(frozen=True, kw_only=True, eq=False)
class CampaignSpec:
    """A campaign, ready to run."""

    drives: dict[str, Drive | RoutedDrive] = meaning("by the name that the SPEC gives")
    axes: tuple[Axis, ...] = meaning("dimensions of the design")
    design: Design = meaning("which points are visited")
    computation: Computation = meaning("what is computed for each row")
    motion: Mapping[str, Any] = meaning("values of the SPEC, in SI")
    goals: Mapping[str, Any] = meaning("values of the SPEC, in SI")
    seed: int = meaning("of the rows' random numbers")
    chunk: int | None = meaning("rows of a chunk; None: about five seconds of work")
    identity: dict[str, Any] = meaning("everything that bears on the results, by key of the SPEC")

    @property
    def units(self) -> dict[str, str]:
        """SI unit of each varied key; "" of text and flags."""
        return {key: unit for axis in self.axes for key, unit in axis.units.items()}

    def values(self, first: int, last: int) -> dict[str, NDArray[Any]]:
        """Values of the varied keys at some rows.

        Parameters
        ----------
        first, last : int
            Rows from `first` to before `last`.

        Returns
        -------
        dict of str to ndarray, each of shape (last - first,)
            In SI, by key.
        """
        points = checked_points(self.design, first, last, len(self.axes))
        return {
            key: spread.at(points[:, place])
            for place, axis in enumerate(self.axes)
            for key, spread in axis.spreads.items()
        }


def checked_points(design: Design, first: int, last: int, axes: int) -> Array:
    """Points of a design. Raises `InputRefused` if they are not of the shape, or outside the unit cube."""
    points = np.asarray(design.points(first, last), dtype=float)
    inside = points.shape == (last - first, axes) and bool(np.all((points >= 0.0) & (points <= 1.0)))
    if not inside:
        said = f"design: points of rows {first} to {last} are no array of shape"
        raise InputRefused(f"{said} ({last - first}, {axes}) between 0 and 1: correct the design")
    return points


def read_spec(
    path: str | Path, *, design: Design | None = None, computation: Computation | None = None
) -> CampaignSpec:
    """Read the SPEC of a campaign, design and computation replaced if given; refused if not understood."""
    make = partial(spec_of, folder=Path(path).parent, design=design, computation=computation)
    return read_toml(path, "write TOML with drive = ..., [vary], [design] and [compute]", make)


def spec_of(
    content: Mapping[str, Any],
    folder: Path,
    *,
    design: Design | None = None,
    computation: Computation | None = None,
) -> CampaignSpec:
    """A campaign from the tables of its SPEC, files named from a folder; refused if not understood."""
    for key in content:
        require_known(key, TABLES, f'unknown key "{key}"')
    compute = table_of("compute", content.get("compute", {}))
    made: Computation = computation or named_computation(compute)
    options = kinds()[made.what].numbers if isinstance(made, NamedComputation) else {}
    drives = _drives(content.get("drive"), folder)
    vary = dict(table_of("vary", content.get("vary", {})))
    if len(drives) > 1:
        vary = {DRIVE: {"values": list(drives)}} | vary

    def unit(key: str) -> str:
        return unit_of(key, options, drives.values())

    varied = varied_keys(vary, unit, folder)
    if not varied:
        raise InputRefused("vary is empty: name at least one key and its values")
    if isinstance(made, NamedComputation):
        check_required(made, varied)
    axes = axes_of(varied)
    table = table_of("design", content.get("design", {}))
    seed = whole_of("design.seed", table.get("seed", 0), least=0)
    laid_out = design or design_of(table, axes, seed)
    motion = _quantities(content, "motion", MOTION_UNITS)
    goals = _quantities(content, "goals", goal_units() if "goals" in content else {})
    identity: dict[str, Any] = {f"drive.{name}": content_hash(drive) for name, drive in drives.items()}
    identity |= {f"vary.{key}.{word}": v for key, one in varied.items() for word, v in one.said.items()}
    identity |= {"design.kind": laid_out.identity, "design.rows": laid_out.rows, "design.seed": seed}
    identity |= {"compute.what": made.identity}
    if isinstance(made, NamedComputation):
        identity |= {f"compute.{key}": value for key, value in made.options.items()}
    identity |= {f"motion.{key}": value for key, value in motion.items()}
    identity |= {f"goals.{key}": value for key, value in goals.items()}
    return CampaignSpec(
        drives=drives,
        axes=axes,
        design=laid_out,
        computation=made,
        motion=motion,
        goals=goals,
        seed=seed,
        chunk=_chunk(compute.get("chunk", AUTO), made),
        identity=identity,
    )


def _drives(given: Any, folder: Path) -> dict[str, Drive | RoutedDrive]:
    names = given if isinstance(given, list) else [given]
    if given is None or not names:
        raise InputRefused('drive is missing: write drive = "NAME or path", or a list of them')
    found: dict[str, Drive | RoutedDrive] = {}
    for name in names:
        word = text_of("drive", name)
        beside = folder / word
        found[word] = load_drive(beside if beside.is_file() else word)
    return found


def _quantities(content: Mapping[str, Any], name: str, units: Mapping[str, str]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in table_of(name, content.get(name, {})).items():
        require_known(key, units, f'unknown key "{name}.{key}"', f"{name}.")
        unit, place = units[key], f"{name}.{key}"
        found[key] = whole_of(place, value) if unit == "count" else quantity_of(place, value, unit)
    return found


def _chunk(given: Any, computation: Computation) -> int | None:
    if given != AUTO:
        return whole_of("compute.chunk", given)
    return 1 if isinstance(computation, NamedComputation) and kinds()[computation.what].long else None
