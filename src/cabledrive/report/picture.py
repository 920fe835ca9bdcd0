"""One look for all figures, and a figure as part of a page.

A figure is drawn in the light colours; on the page each of them is a variable with a value for light and one
for dark. The hues can be distinguished with any of the common colour deficiencies and reach a contrast of
4.5 as text; what a colour says is said by a label or a line style as well.

Text stays text, in the page's own typeface; every colour of the style becomes a variable of the page. Where
axes lie and what they measure goes with the picture, so that the page can show the values under a pointer.
Nothing in the picture depends on the time or on chance.
"""

import json
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BytesIO
from math import log10
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from cabledrive.answers.figures import SPACE, number
from cabledrive.report.typesetting import typeset_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure
    from matplotlib.text import Annotation


WIDE, CARD_WIDTH = 720, 350  # px
TEXT, SMALL = 12.0, 11.0  # px

COLOURS: dict[str, tuple[str, str]] = {
    "paper": ("#ffffff", "#15181d"),
    "card": ("#f5f6f8", "#1d2127"),
    "ink": ("#1b1f24", "#e4e7eb"),
    "quiet": ("#5a636e", "#9ea7b3"),
    "line": ("#c9ced6", "#414852"),
    "faint": ("#e6e9ed", "#2b3038"),
    "blue": ("#1a5fb4", "#7ab1f7"),
    "orange": ("#b04a00", "#f5a15b"),
    "green": ("#00604f", "#57c7a8"),
    "purple": ("#8a3d86", "#dc97d6"),
    "ochre": ("#7a6200", "#d9bd4e"),
    "red": ("#b3261e", "#ff8f85"),
}


class Hue:
    """The same in the light theme, in which figures are drawn."""

    PAPER, CARD, INK, QUIET, LINE, FAINT, BLUE, ORANGE, GREEN, PURPLE, OCHRE, RED = (
        light for light, _ in COLOURS.values()
    )


SPAN_COLOURS = {"upper": Hue.BLUE, "lower": Hue.ORANGE}
FAMILY_COLOURS = {
    "pulleys out of phase": Hue.BLUE,
    "pulleys in phase": Hue.ORANGE,
    "pulleys at rest": Hue.QUIET,
    "carriage-dominated": Hue.GREEN,
    "motor joint": Hue.PURPLE,
}

_RC: dict[Any, Any] = {
    "axes.edgecolor": Hue.LINE,
    "axes.facecolor": "none",
    "axes.formatter.useoffset": False,
    "axes.grid": False,
    "axes.labelcolor": Hue.QUIET,
    "axes.labelsize": SMALL,
    "axes.linewidth": 1.0,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlecolor": Hue.INK,
    "axes.titlelocation": "left",
    "axes.titlesize": TEXT,
    "axes.unicode_minus": True,
    "figure.dpi": 72,
    "figure.facecolor": "none",
    "font.family": "DejaVu Sans",
    "font.size": SMALL,
    "grid.color": Hue.FAINT,
    "lines.linewidth": 1.8,
    "lines.solid_capstyle": "round",
    "savefig.dpi": 72,
    "svg.fonttype": "none",
    "text.color": Hue.INK,
    "text.parse_math": False,
    "text.usetex": False,
    "xtick.color": Hue.LINE,
    "xtick.labelcolor": Hue.QUIET,
    "xtick.labelsize": SMALL,
    "ytick.color": Hue.LINE,
    "ytick.labelcolor": Hue.QUIET,
    "ytick.labelsize": SMALL,
}


def theme_css() -> str:
    """The colours as variables of the page, light and dark. Returns CSS; print is always light."""
    light, dark = (
        " ".join(f"--{name}: {pair[number]};" for name, pair in COLOURS.items()) for number in (0, 1)
    )
    return f":root {{ {light} }}\n@media screen and (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}\n"


def family_colour(family: str) -> str:
    """Colour of a family of modes. Returns hexadecimal, of the light theme."""
    return FAMILY_COLOURS.get(family, Hue.OCHRE)


def short_family(family: str) -> str:
    """Name of a family without what goes without saying: "out of phase" for "pulleys out of phase"."""
    return family.removeprefix("pulleys ").removesuffix("-dominated").removesuffix(" pulley turning")


def text_width(words: str) -> float:
    """About how long small words [px] will be; rather too much than too little."""
    return 0.6 * SMALL * len(words)


@contextmanager
def house_style(more: dict[Any, Any] | None = None) -> Iterator[None]:
    """The look of the house, with more settings, for figures drawn inside the block."""
    import matplotlib

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_RC | (more or {}))
        yield


# A file of its own: white paper behind it, and letters as outlines, for wherever it is shown.
_FILE_STYLE: dict[Any, Any] = {
    "figure.facecolor": Hue.PAPER,
    "svg.fonttype": "path",
    "svg.hashsalt": "cabledrive",
    "pdf.fonttype": 42,
}


def file_picture(figure: "Figure", form: str) -> bytes:
    """A figure of `file_figure` as the content of a file, "svg", "png" or "pdf", the same for the same."""
    undated: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    with house_style(_FILE_STYLE), BytesIO() as file:
        figure.savefig(file, format=form, dpi=150, metadata=undated.get(form))
        return file.getvalue()


def file_figure(
    draw: Callable[["Figure"], None], size: tuple[float, float], layout: Any = "constrained"
) -> "Figure":
    """A figure for a file of its own, of a size [inch]; ``draw(figure)`` puts axes on it."""
    from matplotlib.figure import Figure

    with house_style(_FILE_STYLE):
        figure = Figure(figsize=size, layout=layout)
        draw(figure)
    return figure


def label(
    axes: "Axes", words: str, at: tuple[float, float], offset: tuple[float, float] = (0.0, 0.0), **looks: Any
) -> "Annotation":
    """Words beside a point of the axes, or of ``xycoords``, at an offset [px]; looks as `Axes.annotate`."""
    return axes.annotate(words, at, xytext=offset, textcoords="offset points", **looks)


def log_axis(axes: "Axes", which: str, pixels: float) -> None:
    """A logarithmic axis with as many plain numbers as ``pixels`` hold; called when the limits are set."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    limits = axes.get_xlim() if which == "x" else axes.get_ylim()
    axes.set_xscale("log") if which == "x" else axes.set_yscale("log")
    axis = axes.xaxis if which == "x" else axes.yaxis
    decade = pixels / abs(log10(limits[1] / limits[0]))
    plain = limits[0] >= 1e-3 and limits[1] <= 1e6
    roomy = plain and decade > (125.0 if which == "x" else 60.0)
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if roomy else (1.0,), numticks=20))
    axis.set_minor_locator(LogLocator(subs=tuple(range(1, 10)), numticks=40))
    axis.set_major_formatter(
        FuncFormatter(lambda value, _: number(value, 3).removeprefix(f"1{SPACE}×{SPACE}"))
    )
    axis.set_minor_formatter(NullFormatter())
    axes.set_xlim(limits) if which == "x" else axes.set_ylim(limits)


_PLACES = re.compile(r' (?:d|x|y)="[^"]*"')  # not the words of a picture, nor its scales
_LONG = re.compile(r"-?\d+\.\d{3,}(?![\de])")  # finer than a hundredth of a pixel


def picture(name: str, draw: Callable[["Figure"], None], *, height: float) -> Markup:
    """Draw a figure, whose name is unique on the page, of a height [px]. Returns inline SVG that scales.

    ``draw(figure)`` puts axes on an empty figure.
    """
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    size = (WIDE, height)
    with house_style({"svg.hashsalt": name}):
        figure = Figure(figsize=(size[0] / 72, size[1] / 72), layout="constrained")
        FigureCanvasSVG(figure)
        draw(figure)
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
    body = _PLACES.sub(lambda m: _LONG.sub(lambda one: f"{round(float(one[0]), 2):g}", m[0]), body)
    body = re.sub(r"\s*\n\s*", "\n", body)
    width, height = size
    axes = Markup(' data-axes="{}"').format(json.dumps(scales)) if scales else ""
    head = f'<svg viewBox="0 0 {width:g} {height:g}" style="max-width: {width:g}px" aria-hidden="true"{axes}>'
    return Markup(f"{head}{body}</svg>")
