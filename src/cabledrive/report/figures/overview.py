"""Where the lowest modes of several machines lie."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from cabledrive.modal import Modes
from cabledrive.report.numbers import number
from cabledrive.report.picture import Picture, picture
from cabledrive.report.style import BLUE, LINE, ORANGE, label, log_axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ROW, _FOOT = 27.0, 72.0  # heights [px]


def overview_picture(name: str, machines: Sequence[str], all_modes: Sequence[Modes]) -> Picture:
    """Draw the lowest frequency of each kind for every machine, machines in order of the first."""
    rows = [(machine, lowest(modes)) for machine, modes in zip(machines, all_modes, strict=True)]
    rows.sort(key=lambda row: row[1])

    def _draw(figure: "Figure", narrow: bool) -> None:
        axes = figure.add_subplot()
        widest = max(rows, key=lambda row: max(row[1]) / min(row[1]))
        for place, row in enumerate(rows):
            _draw_row(axes, place * (1.6 if narrow else 1.0), row, narrow, named=row is widest)
        values = [value for _, pair in rows for value in pair]
        room = (max(values) / min(values)) ** 0.2  # for what stands beside the outermost marks
        axes.set_xlim(
            min(values) / max(room, 3.0 if narrow else 3.4),
            max(values) * max(room**0.7, 3.0 if narrow else 2.6),
        )
        log_axis(axes, "x", 300.0 if narrow else 560.0)
        axes.set_xlabel("frequency [Hz]")
        last = (len(rows) - 1) * (1.6 if narrow else 1.0)
        axes.set_ylim(last + 0.6, -1.3 if narrow else -0.9)
        axes.spines["left"].set_visible(False)
        if narrow:
            axes.set_yticks([])
        else:
            axes.set_yticks(range(len(rows)), [machine for machine, _ in rows])
            axes.tick_params(axis="y", length=0)

    return picture(name, _draw, wide=_ROW * len(rows) + _FOOT, narrow=1.6 * _ROW * len(rows) + _FOOT)


def lowest(modes: Modes) -> tuple[float, float]:
    """Lowest frequency along the cable and across it. Returns ``along, across`` [Hz]."""
    return modes.longitudinal[0].frequency, modes.transverse[0].frequency


def _draw_row(
    axes: "Axes", place: float, row: tuple[str, tuple[float, float]], narrow: bool, *, named: bool
) -> None:
    """One machine; in the row where there is most room the two marks are named."""
    machine, (along, across) = row
    axes.hlines(place, min(along, across), max(along, across), color=LINE, linewidth=1.2)
    axes.plot(along, place, "o", color=BLUE, markersize=7)
    axes.plot(across, place, "D", color=ORANGE, markersize=6)
    if narrow:
        label(axes, machine, (0.0, place), (0, 9), xycoords=("axes fraction", "data"))
    for value, other, colour, word in ((along, across, BLUE, "along"), (across, along, ORANGE, "across")):
        words = [number(value, 3), word] if named else [number(value, 3)]
        side = 1 if value >= other else -1
        label(
            axes,
            "  ".join(words[::side]),
            (value, place),
            (8 * side, 0),
            ha="left" if side > 0 else "right",
            va="center",
            color=colour,
        )
