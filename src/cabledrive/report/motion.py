"""Frames of a run: where the cable and the pulleys are drawn, and by how much too large.

Deflections across the cable and turns of the pulleys are drawn larger than they are, by factors that are
said; the spokes turn with the pulleys, clockwise where the cable of the upper span moves to the right.
"""

from dataclasses import dataclass
from math import cos, hypot, sin

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters import Drive, InputRefused
from cabledrive.report.figures.machine_layout import MachineLayout
from cabledrive.report.figures.sheet import Point
from cabledrive.report.numbers import number
from cabledrive.simulation import SimulationResult

MOST_FRAMES = 72
SECONDS_PER_FRAME = 1.0 / 16.0
POINTS = 41
FIRST_LINE = 18.0  # px
_DEFLECTION, _TURN, _LARGEST_FACTOR = 26.0, 0.6, 1e6  # px, rad


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Motion:
    """Frames of a run."""

    time: Array  # (frames,) [s]
    place: Array  # (points,): shares of the span, from the pulley where it starts
    across: dict[str, Array]  # (frames, points): displacement w of each span, outwards [m]
    angles: Array  # (frames, 2): of drive and load pulley [rad]


def motion_of(result: SimulationResult, most: int = MOST_FRAMES) -> Motion:
    """Frames from the whole fields of a run, the first ``most``; less than two are refused."""
    if len(result.fields) < 2:
        raise InputRefused(
            f"{len(result.fields)} whole fields kept, at least 2 are needed: run with Recording(fields=...)"
        )
    place = np.linspace(0.0, 1.0, POINTS)
    across = {}
    for row, span in enumerate(result.spans):
        at = result.position[row] / result.position[row, -1]
        first = row * (at.size - 1)
        w = result.fields[:most, 2, first : first + at.size]
        across[span] = np.array([np.interp(place, at, field) for field in w])
    time = result.field_time[:most]
    angles = [np.interp(time, result.time, angle) for angle in (result.drive_angle, result.load_angle)]
    return Motion(time=time, place=place, across=across, angles=np.column_stack(angles))


def frame_interval(drive: Drive) -> float:
    """Time between frames that shows the lowest transverse mode in eighteen pictures. Returns [s]."""
    speed = (drive.cable.pretension / drive.cable.stretched_mass_per_length) ** 0.5
    return 2.0 * drive.pulley_distance / speed / 18.0


def factors(motion: Motion) -> tuple[float, float]:
    """How many pixels a metre of deflection has, and how many times too far the pulleys turn."""
    deflection = max(float(np.max(np.abs(field))) for field in motion.across.values())
    turn = float(np.max(np.abs(motion.angles - motion.angles[:1])))
    larger = min(_TURN / turn, _LARGEST_FACTOR) if turn > _TURN / _LARGEST_FACTOR else 1.0
    return _DEFLECTION / deflection if deflection > 0.0 else 0.0, float(f"{larger:.1e}")


def motion_words(layout: MachineLayout, drive: Drive, motion: Motion) -> str:
    """What is drawn too large, and how slow it plays."""
    pixels, turn = factors(motion)
    distance = hypot(layout.load[0] - layout.drive[0], layout.load[1] - layout.drive[1])
    larger = pixels * drive.pulley_distance / distance
    slower = SECONDS_PER_FRAME / float(motion.time[1] - motion.time[0])
    return f"w × {number(larger, 2)}, angles × {number(turn, 2)}, {number(slower, 2)} times slower"


def span_curve(layout: MachineLayout, motion: Motion, span: str, frame: int) -> list[Point]:
    """A span as drawn in a frame; w points out of the loop. ``span``, {"upper", "lower"}. Returns [px]."""
    pixels, _ = factors(motion)
    side = 1.0 if span == "upper" else -1.0
    return [
        layout.off(layout.on_span(span, float(share)), 0.0, side * pixels * float(w))
        for share, w in zip(motion.place, motion.across[span][frame], strict=True)
    ]


def spokes(layout: MachineLayout, motion: Motion, frame: int) -> list[tuple[Point, Point]]:
    """A diameter of drive and load pulley [px] as drawn in a frame, upright at the start."""
    _, larger = factors(motion)
    ends = []
    turned = larger * (motion.angles[frame] - motion.angles[0])
    for axle, radius, angle in zip((layout.drive, layout.load), layout.radii, turned, strict=True):
        along, across = radius * sin(angle), radius * cos(angle)
        ends.append((layout.off(axle, along, across), layout.off(axle, -along, -across)))
    return ends
