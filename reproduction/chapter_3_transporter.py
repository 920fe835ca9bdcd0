"""Figures 3.8 to 3.10: the cable transporter."""

from dataclasses import replace

import numpy as np

from cabledrive.parameters import Drive, load_drive
from reproduction.carriage_position import (
    frequency_against_carriage_position,
    midspan_crossing,
)
from reproduction.chapter_3_shapes import SHAPE_DIFFERS, shape_panel, spans_of
from reproduction.item import ERRATUM, Outcome, outcome, place
from reproduction.judge import claimed
from reproduction.panel import Panel, curve
from reproduction.shapes import mode_shapes

MASS_RATIOS = (0.0, 1.0, 5.0, 10.0, 50.0)


def transporter(quick: bool) -> Outcome:
    """Figs. 3.8 to 3.10: the fundamental over the place of a mass, and its shape with the mass at midspan.

    ``quick``: fewer places.
    """
    drive = load_drive("dissertation-1")
    places = np.linspace(0.0, drive.span_length, 21 if quick else 81)
    data = frequency_against_carriage_position(drive, MASS_RATIOS, places, modes=1)
    found = data["frequency"].to_numpy()[..., 0]
    crossing = midspan_crossing(drive)
    middle = places.size // 2
    items = [
        claimed(
            "figure-3-8-constant",
            "Fig. 3.8: no mass",
            "constant, as in Table 3.2",
            f"{found[0].min():.4f} to {found[0].max():.4f} Hz",
            bool(np.ptp(found[0]) < 1e-6),
            otherwise=SHAPE_DIFFERS,
        ),
        claimed(
            "figure-3-8-heavier",
            "Fig. 3.8: heavier mass",
            "the fundamental falls as the mass grows, at any place",
            f"largest change from one mass to the next at any place {np.max(np.diff(found, axis=0)):.2g} Hz",
            bool(np.all(np.diff(found, axis=0) < 1e-6)),
            otherwise=SHAPE_DIFFERS,
            note="the masses of the print are lost; 0, 1, 5, 10 and 50 times the cable's are chosen",
        ),
        claimed(
            "figure-3-8-midspan",
            "Fig. 3.8: mass at the midpoint",
            "equivalent to no mass",
            f"{found[-1, middle]:.2f} Hz with 50 times the cable's mass, {found[0, middle]:.2f} Hz without",
            False,
            otherwise=(
                ERRATUM,
                f"true below {crossing.mass_ratio:.4g} times the cable's mass; above, the mode that carries "
                "the mass "
                f"is lower. {place('erratum-fig-3-8-midpoint')}",
            ),
        ),
    ]
    shape, rim = _midspan_shape()
    items += [
        claimed(
            "figure-3-9",
            "Fig. 3.9: fundamental shape with the mass at the midpoint",
            "a vibration node at the mass",
            f"the mass moves {shape:.2g} of the largest displacement",
            shape < 1e-6,
            otherwise=SHAPE_DIFFERS,
            note="a mass of 5 times the cable's is chosen",
        ),
        claimed(
            "figure-3-10",
            "Fig. 3.10: spans of the transporter",
            "their motion is coupled with pulley rotation",
            f"rims move {rim:.2g} of the largest displacement",
            rim > 0.5,
            otherwise=SHAPE_DIFFERS,
        ),
    ]
    panels = [
        Panel(
            figure="Fig. 3.8",
            title="Fundamental over the place of the mass; masses chosen",
            x="place over span length",
            y="frequency [Hz]",
            curves=tuple(
                curve(f"chi_m = {ratio:g}", places / drive.span_length, row)
                for ratio, row in zip(MASS_RATIOS, found, strict=True)
            ),
        ),
        *(shape_panel(figure, mode_shapes(_loaded()), 0) for figure in ("Fig. 3.9", "Fig. 3.10")),
    ]
    return outcome(items, panels)


def _loaded() -> Drive:
    drive = load_drive("dissertation-transporter")
    middle = replace(drive.carriage[0], position=drive.span_length / 2)
    return replace(drive, carriage=(middle,))


def _midspan_shape() -> tuple[float, float]:
    """Displacement of the mass and of the rims over the largest one."""
    found = spans_of(mode_shapes(_loaded()), 0)
    largest = max(float(np.max(np.abs(shape))) for shape in found.values())
    upper = found["upper"]
    return abs(float(upper[upper.size // 2])) / largest, abs(float(upper[0])) / largest
