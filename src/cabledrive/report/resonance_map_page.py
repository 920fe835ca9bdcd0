"""The map of the internal resonance as one interactive page that needs no other file and no network."""

import json
from importlib import resources

import jinja2
import numpy as np
from markupsafe import Markup

from cabledrive.report.numbers import number, quantity
from cabledrive.report.style import theme_css
from cabledrive.report.time_plots import instants
from cabledrive.report.typesetting import typeset
from cabledrive.studies.planned_motion import PlannedMotion
from cabledrive.studies.resonance_map import GrowthMap

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


def summary_line(growth: GrowthMap) -> str:
    """The map in one sentence."""
    finite = growth.growth[np.isfinite(growth.growth)]
    reach = (
        f"grows by up to a factor of {number(float(finite.max()))}" if finite.size else "is slack everywhere"
    )
    slack = (
        f"; a span goes slack in {100 * float(np.mean(growth.slack)):.3g} % of it"
        if growth.slack.any()
        else ""
    )
    return (
        f"Between {quantity(float(growth.pretension[0]), 'N')} and "
        f"{quantity(float(growth.pretension[-1]), 'N')}, torque up to "
        f"{quantity(float(growth.torque[-1]), 'N m')}, a small transverse motion {reach} in "
        f"{number(growth.duration)} s{slack}."
    )


def _path(growth: GrowthMap, motion: PlannedMotion) -> list[list[float | None]]:
    """Pretension and torque magnitude along a motion, thinned so that every peak stays."""
    torque = np.abs(motion.torque)
    own = np.full(torque.size, growth.own_pretension)
    pretension = own if motion.pretension is None else motion.pretension
    kept = instants([torque, pretension], torque.size)
    return [_rounded(pretension[kept]), _rounded(torque[kept])]


def _data(growth: GrowthMap, motion: PlannedMotion | None) -> str:
    finite = growth.growth[np.isfinite(growth.growth)]
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
            "path": None if motion is None else _path(growth, motion),
            "highest": float(finite.max()) if finite.size else 10.0,
        },
        allow_nan=False,
    )


def _rounded(values: np.ndarray) -> list[float | None]:
    return [float(f"{value:.6g}") if np.isfinite(value) else None for value in values]
