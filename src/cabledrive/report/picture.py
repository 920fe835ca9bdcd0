"""A figure as part of the page: drawn for wide and for narrow pages, as SVG that follows the page's colours.

Text stays text, in the page's own typeface; every colour of the style becomes a variable of the page. Where
axes lie and what they measure goes with the picture, so that the page can show the values under a pointer.
Nothing in the picture depends on the time or on chance.
"""

import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from io import BytesIO
from typing import TYPE_CHECKING

from markupsafe import Markup

from cabledrive.report import blocks
from cabledrive.report.style import COLOURS, NARROW, WIDE, house_style
from cabledrive.report.typesetting import typeset_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure


_PLACES = re.compile(r' (?:d|x|y)="[^"]*"')  # not the words of a picture, nor its scales
_LONG = re.compile(r"-?\d+\.\d{3,}(?![\de])")  # finer than a hundredth of a pixel


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """One picture for wide pages and one for narrow ones."""

    wide: Markup  # inline SVG
    narrow: Markup  # inline SVG

    def figure(self, *, name: str, alt: str, caption: blocks.Text) -> blocks.Figure:
        """The picture on a page, with its words."""
        return blocks.Figure(name=name, alt=alt, caption=caption, wide=self.wide, narrow=self.narrow)


def picture(
    name: str,
    draw: Callable[["Figure", bool], None],
    *,
    wide: float,
    narrow: float,
) -> Picture:
    """Draw a figure, whose name is unique on the page, twice, of heights for wide and for narrow pages [px].

    ``draw(figure, narrow)`` puts axes on an empty figure.
    """
    return Picture(
        wide=_drawn(f"{name}-w", draw, False, (WIDE, wide)),
        narrow=_drawn(f"{name}-n", draw, True, (NARROW, narrow)),
    )


def _drawn(
    name: str, draw: Callable[["Figure", bool], None], narrow: bool, size: tuple[float, float]
) -> Markup:
    import matplotlib
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    with house_style():
        matplotlib.rcParams["svg.hashsalt"] = name
        figure = Figure(figsize=(size[0] / 72, size[1] / 72), layout="constrained")
        FigureCanvasSVG(figure)
        draw(figure, narrow)
        buffer = BytesIO()
        figure.savefig(buffer, format="svg", metadata={"Date": None})
        scales = [_scales(axes, size) for axes in figure.axes if axes.axison]
    return inline_svg(buffer.getvalue().decode(), name, size, scales)


def _scales(axes: "Axes", size: tuple[float, float]) -> dict[str, list[float | int | str]]:
    """Ends of each axis on the picture [px]; where it measures, its limits, whether by ratios, its label."""
    place = axes.get_position()
    ends = {
        "x": (place.x0 * size[0], place.x1 * size[0]),
        "y": ((1.0 - place.y0) * size[1], (1.0 - place.y1) * size[1]),
    }
    found: dict[str, list[float | int | str]] = {}
    for name, axis in (("x", axes.xaxis), ("y", axes.yaxis)):
        found[name] = [round(end, 1) for end in ends[name]]
        if _measures(axis):
            limits = [float(f"{limit:.6g}") for limit in axis.get_view_interval()]
            low, high = reversed(limits) if axis.get_inverted() else limits
            found[name] += [low, high, int(axis.get_scale() == "log"), typeset_words(axis.get_label_text())]
    return found


def _measures(axis: "Axis") -> bool:
    """Whether the axis has a scale of numbers: not names at its ticks, and not some other law."""
    from matplotlib.ticker import FixedFormatter, NullFormatter

    words = isinstance(axis.get_major_formatter(), FixedFormatter | NullFormatter)
    return axis.get_scale() in ("linear", "log") and not words


def inline_svg(
    text: str,
    name: str,
    size: tuple[float, float],
    scales: list[dict[str, list[float | int | str]]] | None = None,
) -> Markup:
    """An SVG file as part of a page: no prolog, no metadata, no foreign names, colours as variables.

    ``name``: put before the names inside the picture that are referred to; the others are dropped; ``size``:
    width and height [px]; ``scales``: of the axes in the picture.
    """
    body = text[text.index("<svg") : text.rindex("</svg>")]
    body = re.sub(r"<svg\b[^>]*>", "", body, count=1)
    body = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->", "", body, flags=re.S)
    body = body.replace("xlink:href=", "href=")
    referred = set(re.findall(r'(?:href="|url\()#([^")]+)', body))
    body = re.sub(r' id="([^"]*)"', lambda m: f' id="{name}-{m[1]}"' if m[1] in referred else "", body)
    body = re.sub(r'(href="|url\()#', rf"\1#{name}-", body)
    body = re.sub(r"font: ([^;\"]*?)([\d.]+px) [^;\"]*", r"font: \1\2 var(--sans)", body)
    for colour, (light, _) in COLOURS.items():
        body = body.replace(light, f"var(--{colour})")
    body = _PLACES.sub(lambda m: _LONG.sub(_rounded, m[0]), body)
    body = re.sub(r"\s*\n\s*", "\n", body)
    width, height = size
    axes = Markup(' data-axes="{}"').format(json.dumps(scales)) if scales else ""
    head = f'<svg viewBox="0 0 {width:g} {height:g}" style="max-width: {width:g}px" aria-hidden="true"{axes}>'
    return Markup(f"{head}{body}</svg>")


def _rounded(found: re.Match[str]) -> str:
    return f"{float(found[0]):.2f}".rstrip("0").rstrip(".")
