"""A carriage on its way along the span, Fig. 3.8, and the crossing at midspan that its text overlooks."""

from typing import TYPE_CHECKING

from cabledrive.report.numbers import number
from cabledrive.report.picture import Picture, picture
from cabledrive.report.style import BLUE, INK, QUIET, family_colour, label, log_axis, short_family

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def carriage_picture(name: str, along: "xr.Dataset", at_midspan: "xr.Dataset", cable_mass: float) -> Picture:
    """Draw the fundamental against position for several masses, and at midspan two modes against mass.

    ``name``: unique on the page; ``along``: from `frequency_against_carriage_position`; ``at_midspan``: from
    `frequency_against` with the mass of a carriage at midspan; ``cable_mass``: mass of the cable [kg].
    """

    def _draw(figure: "Figure", narrow: bool) -> None:
        rows, columns = (2, 1) if narrow else (1, 2)
        first, second = figure.subplots(rows, columns, squeeze=False).flat
        _draw_positions(first, along)
        _draw_midspan(second, at_midspan, cable_mass)

    return picture(name, _draw, wide=300.0, narrow=560.0)


def _draw_positions(axes: "Axes", data: "xr.Dataset") -> None:
    position, ratios = data["position"].to_numpy(), data["mass_ratio"].to_numpy()
    for place, ratio in enumerate(ratios):
        frequency = data["frequency"].to_numpy()[place, :, 0]
        share = 0.25 + 0.75 * place / max(1, len(ratios) - 1)
        axes.plot(position / position[-1], frequency, color=BLUE, alpha=share, linewidth=1.6)
        words = "no carriage" if ratio == 0.0 else f"{number(ratio, 4)}"
        above = {"va": "bottom", "ha": "left"} if ratio == 0.0 else {"va": "center", "ha": "right"}
        label(axes, words, (0.0, frequency[0]), (3, 3) if ratio == 0.0 else (-6, 0), color=BLUE, **above)
    axes.set_xlim(0.0, 1.0)
    axes.set_xticks([0.0, 0.5, 1.0], ["drive", "midspan", "load"])
    axes.tick_params(axis="y", pad=30)
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)
    axes.set_title("Fundamental [Hz], carriage at x")


def _draw_midspan(axes: "Axes", data: "xr.Dataset", cable_mass: float) -> None:
    ratio = data["value"].to_numpy() / cable_mass
    for frequency, families in zip(data["frequency"].to_numpy(), data["family"].to_numpy(), strict=True):
        colour = family_colour(families[0])
        axes.plot(ratio, frequency, color=colour)
        still = bool(abs(frequency[0] - frequency[-1]) < 1e-6 * frequency[0])
        words = (
            "out of phase: carriage at rest"
            if still
            else f"{short_family(families[0])} moves, {families[-1]}"
        )
        where, offset = (ratio[0], frequency[0]), (4, -11) if still else (14, 0)
        label(axes, words, where, offset, va="center", color=colour)
    for value, frequency in zip(
        data["crossing_value"].to_numpy() / cable_mass, data["crossing_frequency"].to_numpy(), strict=True
    ):
        axes.plot(value, frequency, "o", markersize=12, markerfacecolor="none", markeredgecolor=INK)
        label(axes, f"crossing at {number(value, 4)}", (value, frequency), (6, 12))
    axes.set_xlim(ratio[0], ratio[-1])
    log_axis(axes, "x", 250.0)
    axes.set_xlabel("carriage mass / cable mass", color=QUIET)
    axes.set_title("Both lowest modes [Hz], carriage at midspan")
