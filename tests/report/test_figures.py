"""What the figures draw is what was computed."""

from itertools import pairwise

import numpy as np
import pytest

from cabledrive.mechanics.holding import DRIVE_PULLEY, LOAD_PULLEY
from cabledrive.modal import modes, natural_frequencies
from cabledrive.parameters import load_drive, packaged_drives
from cabledrive.report.figures import ladder, shapes
from cabledrive.report.figures import machine as machine_layout
from cabledrive.report.figures.machine import machine_picture


def below_fifth(name: str):
    drive = load_drive(name)
    return drive, modes(drive, below=1.05 * natural_frequencies(drive, count=5)[-1])


@pytest.mark.parametrize("name", packaged_drives("loop", "line"))
def test_the_staircase_rises_at_every_listed_mode_and_nowhere_else(name):
    """The count knows nothing of the list, so a missed mode would show as a step without a mode."""
    drive, found = below_fifth(name)
    steps = ladder.staircase(drive, found)
    rises = np.repeat(steps.frequency[1:], np.diff(steps.count).astype(int))
    listed = [mode.frequency for mode in found.longitudinal for _ in range(mode.multiplicity)]
    np.testing.assert_allclose(rises, listed, rtol=2e-9)
    assert steps.count[0] == 0
    assert steps.count[-1] == found.certificate.longitudinal


@pytest.mark.parametrize("name", packaged_drives("loop", "line"))
def test_a_drawn_shape_goes_from_rim_to_rim_as_the_pulleys_turn(name):
    """The ends of the drawn spans are the displacements of the rims, to the scale of the drawing."""
    drive, found = below_fifth(name)
    for mode in found.longitudinal:
        drawn = shapes.unrolled(mode, drive)
        rims = {"upper": (DRIVE_PULLEY, LOAD_PULLEY), "lower": (LOAD_PULLEY, DRIVE_PULLEY)}
        largest = max((mode.shape(span, x)[0] for span, x in spread(drive)), key=lambda u: np.abs(u).max())
        scale = np.abs(largest).max()
        for span, (x, u) in drawn.items():
            ends = [mode.joints[rim][0] if rim in mode.joints else 0.0 for rim in rims[span]]
            sign = np.sign(ends[0] * u[0]) or 1.0
            np.testing.assert_allclose(u[[0, -1]], sign * np.array(ends) / scale, atol=1e-9)
            assert np.abs(u).max() <= 1.0 + 1e-12
            assert (x[0], x[-1]) == ((0.0, 1.0) if span == "upper" else (1.0, 2.0))


def spread(drive):
    for span in drive.spans:
        carried = [carriage.position for carriage in drive.carriages_on(span)]
        yield span, np.unique([*np.linspace(0.0, drive.span_length, shapes.POINTS), *carried])


@pytest.mark.parametrize("name", packaged_drives("loop", "line"))
@pytest.mark.parametrize("width", [350.0, 720.0])
def test_the_drawing_keeps_the_proportions_of_the_machine(name, width):
    """Spans to scale; pulleys to one scale of their own that is said where it differs."""
    drive = load_drive(name)
    layout = machine_layout.machine_layout(drive, width, width < 500)
    distance = np.hypot(layout.load[0] - layout.drive[0], layout.load[1] - layout.drive[1])
    per_metre = distance / drive.span_length
    for drawn, pulley in zip(layout.radii, drive.pulley, strict=True):
        assert drawn == pytest.approx(pulley.radius * per_metre * layout.enlarged, rel=1e-9)
    said = "times too large" in machine_picture(drive).wide
    assert said == (machine_layout.machine_layout(drive, 720, False).enlarged > 1.0)
    for (x, y), r in zip((layout.drive, layout.load), layout.radii, strict=True):
        assert r < x < layout.size[0] - r
        assert r < y < layout.size[1] - r
    for span in drive.spans:
        shares = [carriage.position / drive.span_length for carriage in drive.carriages_on(span)]
        places = [layout.on_span(span, share) for share in (0.0, *shares, 1.0)]
        ahead = np.array([np.cos(layout.slope), -np.sin(layout.slope)])  # sag leaves the line alone
        steps = [abs(ahead @ np.subtract(b, a)) for a, b in pairwise(places)]
        np.testing.assert_allclose(steps, np.diff([0.0, *shares, 1.0]) * sum(steps), atol=1e-9)
