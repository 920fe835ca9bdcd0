"""The SPEC of a campaign: drives, what is varied and how, what is computed for each row."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.campaign.computation import Computation, NamedComputation, named_computation, values_of
from cabledrive.campaign.design import Design, design_of
from cabledrive.campaign.vary import Axis, axes_of, varied_keys
from cabledrive.parameters import InputRefused, Machine, content_hash, load_drive
from cabledrive.parameters.fields import described, meaning, require_known
from cabledrive.parameters.keys import unit_in_file
from cabledrive.parameters.toml_values import read_toml, table_of, text_of, whole_of

TABLES = ("drive", "vary", "design", "compute", "motion", "goals")
DRIVE, PLANT, MOTION, GOALS, COMPUTE, OWN = "drive", "plant", "motion", "goals", "compute", "own"
MOTION_UNITS = {"angle": "rad", "rise": "s", "dwell": "s", "pulses": "count", "order": "count"}


@cache
def goal_units() -> dict[str, str]:
    """SI unit of each goal of a study, by name; "count" for a whole number."""
    from cabledrive.studies.study.goals import QUANTITIES  # a study brings most of the package with it

    return {**QUANTITIES, "pulses": "count", "order": "count"}


def unit_of(key: str, options: Mapping[str, str], drives: Iterable[Machine]) -> str:
    """SI unit of a key, "1" for a plain number, "count" for a whole one, "" for text or true and false.

    ``options``: units of the numbers that the computation takes; a key that no drive has is refused.
    """
    space, _, rest = key.partition(".")
    if key == DRIVE:
        return ""
    if space == OWN and rest:
        return "1"
    of_space = {MOTION: MOTION_UNITS, COMPUTE: options, GOALS: goal_units() if space == GOALS else {}}
    if space in of_space:
        units = of_space[space]
        if not units:
            raise InputRefused(f'unknown key "{key}": this computation has no number that can be varied')
        require_known(rest, units, f'unknown key "{key}"', f"{space}.")
        return units[rest]
    refusals = []
    for drive in drives:
        try:
            return unit_in_file(drive, rest if space == PLANT else key)
        except InputRefused as refusal:
            refusals.append(refusal)
    raise refusals[0]


def settings_of(values: Mapping[str, Any], space: str) -> dict[str, Any]:
    """Values of the keys in one name space, without its name; "" stands for the drive file."""
    if space:
        return {key[len(space) + 1 :]: value for key, value in values.items() if key.startswith(f"{space}.")}
    spaces = (PLANT, MOTION, GOALS, COMPUTE, OWN)
    return {key: value for key, value in values.items() if key != DRIVE and key.split(".")[0] not in spaces}


@described
@dataclass(frozen=True, kw_only=True, eq=False)
class CampaignSpec:
    """A campaign, ready to run."""

    drives: dict[str, Machine] = meaning("by the name that the SPEC gives")
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

        Raises
        ------
        InputRefused
            If the points of the design are not of the shape, or outside the unit cube.
        """
        points = np.asarray(self.design.points(first, last), dtype=float)
        shape = (last - first, len(self.axes))
        if points.shape != shape or not np.all((points >= 0.0) & (points <= 1.0)):
            said = f"design: points of rows {first} to {last} are no array of shape"
            raise InputRefused(f"{said} {shape} between 0 and 1: correct the design")
        return {
            key: spread.at(points[:, place])
            for place, axis in enumerate(self.axes)
            for key, spread in axis.spreads.items()
        }


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
    kind = made.kind if isinstance(made, NamedComputation) else None
    options = made.options if isinstance(made, NamedComputation) else {}
    drives = _drives(content.get("drive"), folder)
    vary = dict(table_of("vary", content.get("vary", {})))
    if len(drives) > 1:
        vary = {DRIVE: {"values": list(drives)}} | vary

    def unit(key: str) -> str:
        return unit_of(key, kind.numbers if kind else {}, drives.values())

    varied = varied_keys(vary, unit, folder)
    if not varied:
        raise InputRefused("vary is empty: name at least one key and its values")
    unused = {PLANT, MOTION, GOALS, OWN} - {*kind.spaces} if kind else ()
    for key in (*varied, *content):
        if key.partition(".")[0] in unused:
            raise InputRefused(f"{key} does not bear on compute.what = {made.identity}: leave it out")
    for name in kind.required if kind else ():
        if name not in options and f"compute.{name}" not in varied:
            raise InputRefused(f"compute.{name} is missing: {made.identity} needs it; add it to [compute]")
    axes = axes_of(varied)
    table = table_of("design", content.get("design", {}))
    seed = whole_of("design.seed", table.get("seed", 0), least=0)
    laid_out = design or design_of(table, axes, seed)
    motion, goals = (
        values_of(table_of(name, content.get(name, {})), units, name)
        for name, units in ((MOTION, MOTION_UNITS), (GOALS, goal_units() if GOALS in content else {}))
    )
    chunk = compute.get("chunk", "auto")
    identity: dict[str, Any] = {f"drive.{name}": content_hash(drive) for name, drive in drives.items()}
    identity |= {f"vary.{key}.{word}": v for key, one in varied.items() for word, v in one.said.items()}
    identity |= {"design.kind": laid_out.identity, "design.rows": laid_out.rows, "design.seed": seed}
    identity |= {"compute.what": made.identity}
    for name, values in ((COMPUTE, options), (MOTION, motion), (GOALS, goals)):
        identity |= {f"{name}.{key}": value for key, value in values.items()}
    return CampaignSpec(
        drives=drives,
        axes=axes,
        design=laid_out,
        computation=made,
        motion=motion,
        goals=goals,
        seed=seed,
        chunk=whole_of("compute.chunk", chunk) if chunk != "auto" else 1 if kind and kind.long else None,
        identity=identity,
    )


def _drives(given: Any, folder: Path) -> dict[str, Machine]:
    names = given if isinstance(given, list) else [given]
    if given is None or not names:
        raise InputRefused('drive is missing: write drive = "NAME or path", or a list of them')
    found: dict[str, Machine] = {}
    for name in names:
        word = text_of("drive", name)
        beside = folder / word
        found[word] = load_drive(beside if beside.is_file() else word)
    return found
