"""Natural frequencies over the travel of a machine with routes: over the bed, over the shaft."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from cabledrive.parameters import InputRefused
from cabledrive.parameters.route import RoutedDrive
from cabledrive.report.blocks import Figure
from cabledrive.report.map_figure import draw_map
from cabledrive.report.picture import picture
from cabledrive.studies.mode_map import map_modes
from cabledrive.studies.travel import travels

if TYPE_CHECKING:
    import xarray as xr

COUNT, MOST_PULLEYS = 3, 14
"""Modes of each kind; pulleys above which a map would take longer than the rest of the page."""
_HEIGHT = 300.0  # px


def travel_figures(drive: RoutedDrive, name: str) -> Iterator[Figure]:
    """A figure for each motion of a body that strains nothing; none of machines with many pulleys."""
    if len(drive.pulley) > MOST_PULLEYS:
        return
    for number, travel in enumerate(travels(drive)):
        keys = next(iter(travel))
        try:
            found = map_modes(drive, travel, count=COUNT)
        except InputRefused:  # nowhere but at its place is it a machine
            continue
        yield _figure(f"travel-{name}-{number}", keys, found)


def _figure(name: str, keys: tuple[str, ...], found: "xr.Dataset") -> Figure:
    def _draw(figure: Any, narrow: bool) -> None:
        draw_map(figure, found, 1)

    drawn = picture(name, _draw, wide=_HEIGHT, narrow=_HEIGHT)
    along = keys[0] + (f" (with {', '.join(keys[1:])})" if len(keys) > 1 else "")
    certified, points = int(found["certified"].sum()), int(found["certified"].size)
    lost = int((found["reason"] != "").sum())
    said = f"The lists of {certified} of {points} places are certified"
    said += f"; at {lost} the machine cannot be" if lost else ""
    return drawn.figure(
        name=name,
        alt=f"Natural frequencies of the first {COUNT} modes of each kind over {along}.",
        caption=f"Natural frequencies over {along}, from end to end of the machine's drawing. {said}.",
    )
