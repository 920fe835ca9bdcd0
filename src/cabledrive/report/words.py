"""Words of pages: certificates, derived quantities, names that can stand in a link, texts of templates."""

import re
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from importlib import resources
from itertools import chain, count
from math import radians
from typing import Any

from cabledrive.answers.figures import Row, figures_of, number, quantity
from cabledrive.answers.keys import Keys
from cabledrive.mechanics import DerivedQuantities
from cabledrive.mechanics.datasheet import REST
from cabledrive.modal import Mode, Modes
from cabledrive.modal.lowest import LOWEST as OF_LOWEST
from cabledrive.modal.mode import LONGITUDINAL, SAGGING, TRANSVERSE, Certificate
from cabledrive.modal.mode_rows import mode_rows
from cabledrive.modal.ranges import INCOMPLETE
from cabledrive.report.blocks import Table, listed, table_text

LOWEST = "Lowest longitudinal frequency"
CLOSED = figures_of(DerivedQuantities)
DATASHEET = CLOSED | {
    REST: (
        Row("cable_length", "Length of all spans", "m", ""),
        Row("highest_tension", "Highest tension", "N", ""),
        *CLOSED[REST],
    ),
    LOWEST: (
        Row("lowest_frequency_free_hz", "Motor free (without a motor: drive pulley free)", "Hz", ""),
        Row("lowest_frequency_held_hz", "Motor held (without a motor: drive pulley held)", "Hz", ""),
        Row("lowest_frequency_holding_hz", "Motor on its holding stiffness", "Hz", ""),
        Row("rigid_body_modes", "Motions that strain nothing", form="d"),
    ),
}
"""Figures of a data sheet by their headings."""

OF_MODE = Keys(
    "frequency_hz=frequency kind family multiplicity kinetic_shares proven span? plane? section? model? "
    "clamped? strain_shares?",
    of=Mode,
)
OF_PROOF = Keys(
    "below_hz=below longitudinal_below_hz=longitudinal_below transverse_below_hz=transverse_below count "
    "longitudinal transverse enclosure slope",
    of=Certificate,
)
OF_MODES = Keys(
    "modes certified certified_reason? warnings certificate rigid_body_modes motor hold at_torque",
    parts={"modes": OF_MODE, "certificate": OF_PROOF},
    of=Modes,
)
LISTED = Keys("", also=(OF_LOWEST, OF_MODES))
"""Keys of a list of modes, with the lowest frequencies before it."""


def anchor(title: str) -> str:
    """A title as the name of a place on the page: lower-case letters first, digits and hyphens."""
    plain = unicodedata.normalize("NFKD", title).encode("ascii", "ignore").decode().lower()
    words = re.sub(r"[^a-z0-9]+", "-", plain).strip("-")
    return words if words[:1].isalpha() else f"drive-{words}".rstrip("-")


def anchors(titles: Sequence[str]) -> tuple[str, ...]:
    """Anchors of several titles, numbered where they would be the same. Returns all different."""
    taken: list[str] = []
    for name in map(anchor, titles):
        numbered = (f"{name}-{number}" for number in count(2))
        taken.append(next(one for one in chain([name], numbered) if one not in taken))
    return tuple(taken)


HELD = {"free": "free", "held": "held", "holding": "on its holding stiffness"}
"""How the rotor of a motor is held, in words."""


def speed_unit(coordinate: str) -> str:
    """Unit of the speed of a coordinate."""
    return "m/s" if coordinate.endswith((".x", ".y")) else "rad/s"


Say = Callable[..., str]

_FACTORS = {"deg": radians(1.0), "mm": 1e-3, "um": 1e-6, "%": 1e-2}
_SPACES = re.compile(r"[ \n]+")


def texts(name: str, package: str = "cabledrive.report") -> Say:
    """Texts of ``templates/texts/NAME.txt`` of a package, one plain line each, by macro's name and values."""

    def say(macro: str, /, **values: object) -> str:
        said = getattr(_template(package, name).module, macro)(**values)
        return _SPACES.sub(" ", str(said)).strip(" ")

    return say


@cache
def _template(package: str, name: str) -> Any:
    """A text of a package as a template of jinja2, which the first text loads."""
    import jinja2

    # The page escapes its texts: here they are plain.
    environment = jinja2.Environment(autoescape=False, undefined=jinja2.StrictUndefined)
    environment.filters |= {
        "in": in_unit,
        "number": number,
        "quantity": quantity,
        "sentences": sentences,
        "largest": lambda values: max(abs(value) for value in values),
    }
    environment.globals["DEGREE"] = radians(1.0)
    source = (resources.files(package) / "templates" / "texts" / f"{name}.txt").read_text(encoding="utf-8")
    return environment.from_string(source)


def in_unit(value: float, unit: str, digits: int = 3) -> str:
    """A value in SI in a fixed unit: ``in_unit(0.0021, "mm")`` is "2.1 mm"."""
    return f"{value / _FACTORS.get(unit, 1.0):.{digits}g} {unit}"


def sentences(lines: Iterable[str]) -> str:
    """Lines as sentences."""
    return " ".join(f"{line[:1].upper()}{line[1:].rstrip('.')}." for line in lines)


MODES = (
    Row("frequency", "frequency", "Hz", ".9g"),
    Row("count", "modes", form="d"),
    Row("kind", "kind", kind="text"),
    Row("family", "family", kind="text"),
    Row("where", "where", kind="text"),
)


def modes_table(found: Modes, across: int | None = None) -> Table:
    """The modes, what repeats in both planes and spans in one row; ``across``: most transverse rows."""
    rows, left = mode_rows(found), 0
    if across is not None:
        along, transverse = ([one for one in rows if one.kind == kind] for kind in (LONGITUDINAL, TRANSVERSE))
        rows, left = (*along, *transverse[:across]), len(transverse) - across
    note = f"{left} more transverse frequencies." if left > 0 else ""
    caption = "Natural modes: what moves, and where the kinetic energy of those along the rope is."
    return listed(caption, MODES, rows, note)


def modes_text(found: Modes) -> str:
    """Table of the modes and the certificate below it."""
    return "\n".join([table_text(modes_table(found)), "", certificate_line(found), *_remarks(found)])


def certificate_line(found: Modes) -> str:
    """Completeness of a list of modes, in one sentence."""
    proof = found.certificate
    held = f"{proof.count} modes ({proof.longitudinal} longitudinal, {proof.transverse} transverse)"
    if found.certified:
        return f"Complete up to {proof.below:.8g} Hz (certified): {held}."
    if found.certified_reason != INCOMPLETE:
        return f"Not certified: {found.certified_reason}. Count up to {proof.below:.8g} Hz: {held}."
    return f"NOT complete: {held} exist up to {proof.below:.8g} Hz; the list lacks some of them."


def _remarks(found: Modes) -> Iterator[str]:
    """What the rows do not show."""
    proof = found.certificate
    reached = ((LONGITUDINAL, proof.longitudinal_below), (TRANSVERSE, proof.transverse_below))
    for kind, below in reached:
        if any(mode.frequency > proof.below for mode in found.modes if mode.kind == kind):
            yield f"{kind.capitalize()} modes alone are listed up to {below:.8g} Hz."
    yield from (f"Transverse modes: {line}." for line in [_models(found)] if line)
    yield from (f"Warning: {line}." for line in found.warnings)
    yield from rigid_words(found)


def rigid_words(found: Modes) -> list[str]:
    """Motions that strain nothing, in a sentence where there are any."""
    return [f"Rigid-body modes not listed: {found.rigid_body_modes}."] if found.rigid_body_modes else []


def _models(found: Modes) -> str:
    """What the cable is taken for in each plane."""
    planes = (
        (plane, sorted({m.model or "" for m in found.transverse if m.plane == plane})) for plane in "wv"
    )
    words = {"w": "in the plane of gravity", "v": "across it"}
    parts = [(words[plane], " and ".join(models)) for plane, models in planes if models]
    if len({models for _, models in parts}) == 1:
        return parts[0][1]
    said = "; ".join(f"{models} {plane}" for plane, models in parts)
    return said.replace(SAGGING, f"{SAGGING} with slopes up to {found.certificate.slope:.2g}")
