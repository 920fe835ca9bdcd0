"""One look for all figures: colours that follow the page from light to dark, sizes, spare axes.

A figure is drawn in the light colours; on the page each of them is a variable with a value for light and one
for dark. The hues can be distinguished with any of the common colour deficiencies and reach a contrast of
4.5 as
text; what a colour says is said by a label or a line style as well.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from math import log10
from typing import TYPE_CHECKING, Any

from cabledrive.report.numbers import SPACE, number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Annotation

WIDE, NARROW = 720, 350  # px
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
PAPER, CARD, INK, QUIET, LINE, FAINT, BLUE, ORANGE, GREEN, PURPLE, OCHRE, RED = (
    light for light, _ in COLOURS.values()
)
SPAN_COLOURS = {"upper": BLUE, "lower": ORANGE}
FAMILY_COLOURS = {
    "pulleys out of phase": BLUE,
    "pulleys in phase": ORANGE,
    "pulleys at rest": QUIET,
    "carriage-dominated": GREEN,
    "motor joint": PURPLE,
}

_RC: dict[Any, Any] = {
    "axes.edgecolor": LINE,
    "axes.facecolor": "none",
    "axes.formatter.useoffset": False,
    "axes.grid": False,
    "axes.labelcolor": QUIET,
    "axes.labelsize": SMALL,
    "axes.linewidth": 1.0,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlecolor": INK,
    "axes.titlelocation": "left",
    "axes.titlesize": TEXT,
    "axes.unicode_minus": True,
    "figure.dpi": 72,
    "figure.facecolor": "none",
    "font.family": "DejaVu Sans",
    "font.size": SMALL,
    "grid.color": FAINT,
    "lines.linewidth": 1.8,
    "lines.solid_capstyle": "round",
    "savefig.dpi": 72,
    "svg.fonttype": "none",
    "text.color": INK,
    "text.parse_math": False,
    "text.usetex": False,
    "xtick.color": LINE,
    "xtick.labelcolor": QUIET,
    "xtick.labelsize": SMALL,
    "ytick.color": LINE,
    "ytick.labelcolor": QUIET,
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
    return FAMILY_COLOURS.get(family, OCHRE)


def short_family(family: str) -> str:
    """Name of a family without what goes without saying: "out of phase" for "pulleys out of phase"."""
    return family.removeprefix("pulleys ").removesuffix("-dominated").removesuffix(" pulley turning")


def text_width(words: str) -> float:
    """About how wide small words [px] will be; rather too much than too little."""
    return 0.6 * SMALL * len(words)


@contextmanager
def house_style() -> Iterator[None]:
    """The look of the house for figures drawn inside the block."""
    import matplotlib

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_RC)
        yield


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
