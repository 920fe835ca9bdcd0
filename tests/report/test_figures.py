"""What the figures draw is what was computed."""

import re
from functools import cache

import numpy as np
import pytest
from matplotlib.figure import Figure

import cabledrive as cd
from cabledrive.modal.mode_rows import mode_rows
from cabledrive.report.animation import controlled_film
from cabledrive.report.figures import run_histories
from cabledrive.report.figures.shapes import POINTS, SIZE, machine_size
from cabledrive.report.figures.sheet import drawn_machine
from cabledrive.report.mode_figure import mode_figure, mode_picture
from cabledrive.rig import Motion, track
from cabledrive.simulation import Pluck, Recording, Scheme, Start, simulate


@pytest.fixture(scope="module")
def idlers():
    drive = cd.load_drive("printer-idlers")
    found = cd.modes(drive, count=2)
    return drive, found, mode_figure(drive, found, most=1).axes


def test_a_transverse_mode_of_a_machine_with_routes_is_drawn_across_its_spans(idlers):
    """The drawn displacement of each span, over the largest of all, is that of the mode."""
    drive, found, axes = idlers
    shown = drawn_machine(drive)[0]  # a slim one, so that its height is stretched
    assert axes[1].get_title(loc="left").endswith("; y × 10.7")
    curves = [np.array(line.get_xydata()) for line in axes[1].lines if len(line.get_xydata()) == POINTS]
    assert len(curves) == len(drive.free_spans)
    mode, drawn, exact = mode_rows(found.transverse)[0].modes[0], [], []
    for curve, span, own in zip(curves, drive.free_spans, shown.free_spans, strict=True):
        rest = np.array(own.contacts[0]) + np.outer(np.linspace(0, own.length, POINTS), own.along)
        drawn.append((curve - rest) @ np.array((-own.along[1], own.along[0])))
        exact.append(np.real(mode.shape(span.name, np.linspace(0, span.length, POINTS))[0]))
    drawn, exact = np.concatenate(drawn), np.concatenate(exact)
    size = SIZE * machine_size(shown)
    np.testing.assert_allclose(drawn, size * exact / np.abs(exact).max(), atol=1e-9 * size)
    assert mode_picture(drive, found, "svg", most=1).startswith(b"<?xml")


# --- Pictures and animation of the cable in time
DRIVE = cd.load_drive("dissertation-2")


@cache
def run():
    plucks = (Pluck(height=2e-3), Pluck(height=1e-3, span="lower"), Pluck(height=1e-3, plane="v"))
    recording = Recording(rate=10_000.0, fields=20)
    return simulate(DRIVE, 0.05, start=Start(plucks=plucks), scheme=Scheme(segments=20), recording=recording)


def test_the_spectrum_marks_the_certified_modes():
    marks = run_histories.spectrum_marks(DRIVE)
    longitudinal = [frequency for frequency, kind in marks if kind == "longitudinal"]
    assert longitudinal == [pytest.approx(cd.natural_frequencies(DRIVE, count=1)[0])]
    transverse = [frequency for frequency, kind in marks if kind == "transverse"]
    # the sag parts the planes and couples the spans, by less than 2e-5
    orders = np.rint(np.array(transverse) / transverse[0])
    assert set(orders) == {1, 2, 3, 4}
    np.testing.assert_allclose(transverse, transverse[0] * orders, rtol=2e-5)
    axes = Figure().add_subplot()
    run_histories.draw_spectrum(axes, run(), marks)
    assert sorted(line.get_xdata()[0] for line in axes.lines[1:]) == [frequency for frequency, _ in marks]


# --- The film of a controlled run: every picture shows the run at its time
def test_every_picture_says_the_error_at_its_time():
    drive, motion = cd.load_drive("dissertation-3"), Motion(angle=15.0, rise=0.2, dwell=0.05)
    found = track(drive, controller="pd", bandwidth=20.0, plant="model-3", motion=motion)
    page = controlled_film(drive, found)
    said = re.findall(r">(\d+\.\d+) s, error (-?[\d.]+) deg<", page)
    assert len(said) == 64
    for time, error in said:
        at = np.abs(found.time - float(time)) <= 0.0005 + 1e-9
        errors = np.degrees(found.error[at])
        assert errors.min() - 1e-4 <= float(error) <= errors.max() + 1e-4
    assert float(said[-1][0]) == pytest.approx(found.time[-1], abs=5e-4)
