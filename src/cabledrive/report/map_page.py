"""Maps as interactive pages that need no other file: of natural frequencies, of the internal resonance."""

import json
from importlib import resources
from typing import TYPE_CHECKING

import jinja2
import numpy as np
from markupsafe import Markup

from cabledrive.answers.figures import number, quantity
from cabledrive.parameters import Machine, content_hash
from cabledrive.report.blocks import Block, Chapter, Figure, Note, Panel, Plot, in_turn, instants
from cabledrive.report.machine.tables import zones_table
from cabledrive.report.mode_figure import draw_campbell, draw_map, fields_of, plane_of
from cabledrive.report.page import page_of
from cabledrive.report.picture import picture, theme_css
from cabledrive.report.typesetting import typeset
from cabledrive.report.words import HELD, speed_unit
from cabledrive.studies.excitation_orders import Campbell
from cabledrive.studies.planned_motion import PlannedMotion
from cabledrive.studies.resonance_map import GROWN, GrowthMap, SpotCheck

if TYPE_CHECKING:
    import xarray as xr


METHOD = "exact dynamic stiffness at every point, modes isolated by counting"
MOST_CURVES = 7
MOST_BRANCHES = 10


def map_html(drive: Machine, found: "xr.Dataset", excited: Campbell | None = None) -> str:
    """The page of a map; HTML that needs no other file."""
    blocks: list[Block] = [_notes(found), *([_field(found)] if len(plane_of(found)) > 1 else ())]
    blocks += [_curves(found), *(_excited(excited) if excited is not None else ())]
    chapter = Chapter("Natural frequencies", "map", tuple(blocks), methods=(METHOD,))
    subtitle = "Natural frequencies over " + ", ".join(str(dim) for dim in found["certified"].dims)
    hashes = ((drive.name, content_hash(drive)),)
    return page_of(drive.title or drive.name, subtitle, (chapter,), hashes)


def _notes(found: "xr.Dataset") -> Note:
    certified, points = int(found["certified"].sum()), int(found["certified"].size)
    text = f"Motor {HELD[found.attrs['motor']]}. The lists of {certified} of {points} points are certified "
    return Note(text=f"{text}complete.", tone="good" if certified == points else "warning")


def _field(found: "xr.Dataset") -> Figure:
    height = 330.0 * -(-len(fields_of(found)) // 2)
    return Figure(
        name="map-field",
        alt="Fields of natural frequency over two figures of the machine.",
        caption="Frequency of the mode in which each coordinate has most of its energy."
        if "coordinate_hz" in found
        else "The lowest longitudinal modes.",
        drawing=picture("map-field", lambda figure: draw_map(figure, found, 2), height=height),
    )


def _curves(found: "xr.Dataset") -> Plot:
    """Curves over the first figure, one for some values of the second."""
    first, *second = plane_of(found)
    order = np.argsort(found[first].values)
    if second:
        size = found.sizes[second[0]]
        at = [number(float(value), 4) for value in found[second[0]].values]
        picks = np.unique(np.linspace(0, size - 1, min(size, MOST_CURVES)).round().astype(int))
        panels = [
            Panel(name, "Hz", in_turn((f"{second[0]} = {at[i]}", values.T[i]) for i in picks))
            for name, data in fields_of(found)
            for values in [data.transpose(first, second[0]).values[order]]
        ]
    else:
        modes, rest = found["mode"].values, {str(d): 0 for d in found["certified"].dims if d != first}
        panels = [
            Panel(kind, "Hz", in_turn((f"mode {m}", data.sel(mode=m).values[order]) for m in modes))
            for kind in ("longitudinal", "transverse")
            for data in [found[f"{kind}_hz"].isel(rest)]
        ]
    return Plot(
        name="map-curves",
        alt=f"Natural frequencies over {first}.",
        caption="Move the pointer for values, drag to zoom.",
        points=found[first].values[order].astype(float),
        along=first,
        unit=str(found[first].attrs["units"]),
        panels=tuple(panels),
    )


def _excited(found: Campbell) -> tuple[Block, ...]:
    """Campbell picture, its modes over the first key to be read off, and the table of zones."""
    unit, place = speed_unit(found.coordinate), "m" if found.key.endswith((".x", ".y")) else ""
    shown = Figure(
        name="campbell",
        alt="Frequencies of the modes over speed with the orders of excitation as lines.",
        caption="Each mode is the band of its frequencies over all places; shaded speeds are to be avoided. "
        f"Every mode up to {number(found.covered, 4)} Hz was searched.",
        drawing=picture("campbell", lambda figure: draw_campbell(figure, found), height=520.0),
    )
    places, first = np.unique(found.places, return_index=True)
    heaviest = sorted(found.branches, key=lambda own: -own.weight)[:MOST_BRANCHES]
    hertz = [(own.name, own.hertz[first]) for own in heaviest]
    for name, rate in found.orders.items():
        hertz.append((f"{name} at {found.high:.4g} {unit}", np.full(places.size, rate * found.high)))
    curves = Plot(
        name="campbell-places",
        alt=f"Modes that the orders can meet, over {found.key}.",
        caption="The heaviest modes, and the frequency of each order at the highest speed.",
        points=places,
        along=found.key,
        unit=place,
        panels=(Panel("modes and orders", "Hz", in_turn(hertz)),),
    )
    return shown, curves, zones_table(found)


_TEMPLATES = resources.files("cabledrive.report") / "templates"


def resonance_map_page(
    growth: GrowthMap, validation: str = "", *, motion: PlannedMotion | None = None
) -> str:
    """Set the map as HTML, with what the exact loop says at some points, and a motion drawn as a path."""
    from cabledrive.parameters.version import __version__

    text = (_TEMPLATES / "resonance_map.html").read_text(encoding="utf-8")
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined)
    html = environment.from_string(text).render(
        map=growth,
        css=Markup(theme_css() + (_TEMPLATES / "report.css").read_text(encoding="utf-8")),
        data=Markup(_data(growth, motion).replace("<", "\\u003c")),
        summary=summary_line(growth),
        validation=validation,
        motion=motion is not None,
        number=number,
        version=__version__,
    )
    return typeset(html)


def spot_check_line(checks: tuple[SpotCheck, ...]) -> str:
    """What the spot checks say, for a caption."""
    if not checks:
        needs = "needs spans without carriages that vibrate in their first mode"
        return f"No spot check: the comparison with the full nonlinear model {needs}."
    taut = [check for check in checks if check.exact is not None]
    worst = max((abs(check.growth / check.exact - 1.0) for check in taut if check.exact), default=0.0)
    slack = f", {len(checks) - len(taut)} of them slack there" if len(taut) < len(checks) else ""
    grown = sum(check.growth > GROWN for check in checks)
    return (
        f"Full nonlinear model at {len(checks)} random points, {grown} of them inside the instability "
        f"region{slack}: the growth differs by up to {100 * worst:.2g} %."
    )


def summary_line(growth: GrowthMap) -> str:
    """The map in one sentence."""
    finite, slack = growth.growth[np.isfinite(growth.growth)], 100 * float(np.mean(growth.slack))
    reach = f"grows by up to a factor of {number(float(finite.max()))}" if finite.size else ""
    low, high = (quantity(float(growth.pretension[end]), "N") for end in (0, -1))
    return (
        f"Between {low} and {high}, torque up to {quantity(float(growth.torque[-1]), 'N m')}, a small "
        f"transverse motion {reach or 'is slack everywhere'} in {number(growth.duration)} s"
        + (f"; a span goes slack in {slack:.3g} % of it." if slack else ".")
        + ("" if growth.seen_from is None else f" {SEEN.format(number(growth.seen_from))}")
        + (f" {WEIGHS}" if growth.weighs else "")
    )


SEEN = "At tuning a vanishing motion doubles in that time from {} times the threshold on."
WEIGHS = (
    "The map is of the straight cable without weight: sag, or carriages that hang on it, change the tensions "
    "of this machine, and with them the thresholds that resonance states."
)


def _data(growth: GrowthMap, motion: PlannedMotion | None) -> str:
    finite, path = growth.growth[np.isfinite(growth.growth)], None
    if motion is not None:  # pretension and torque magnitude along it, thinned so that every peak stays
        torque = np.abs(motion.torque)
        own = np.full(torque.size, growth.own_pretension)
        pretension = own if motion.pretension is None else motion.pretension
        kept = instants([torque, pretension], torque.size)
        path = [_rounded(pretension[kept]), _rounded(torque[kept])]
    return json.dumps(
        {
            "pretension": _rounded(growth.pretension),
            "torque": _rounded(growth.torque),
            "growth": [_rounded(row) for row in growth.growth],
            "pulley": [_rounded(row) for row in growth.pulley],
            "threshold": _rounded(growth.threshold),
            "tuned": list(growth.tuned),
            "own_pretension": growth.own_pretension,
            "own_torque": growth.own_torque,
            "path": path,
            "highest": float(finite.max()) if finite.size else 10.0,
        },
        allow_nan=False,
    )


def _rounded(values: np.ndarray) -> list[float | None]:
    return [float(f"{value:.6g}") if np.isfinite(value) else None for value in values]
