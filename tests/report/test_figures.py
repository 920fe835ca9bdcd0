"""What the figures draw is what was computed."""

import re
from functools import cache

import numpy as np
import pytest
from matplotlib.figure import Figure

import cabledrive as cd
from cabledrive.mechanics.holding import DRIVE_PULLEY, LOAD_PULLEY
from cabledrive.modal.mode_rows import mode_rows
from cabledrive.report.animation import animation_page, controlled_film
from cabledrive.report.figures import ladder, run_histories, shapes
from cabledrive.report.figures.moving_machine import draw_machine
from cabledrive.report.figures.shapes import POINTS, SIZE, machine_size
from cabledrive.report.figures.sheet import Sheet, drawn_machine
from cabledrive.report.mode_figure import mode_figure, mode_picture
from cabledrive.rig import Motion, track
from cabledrive.simulation import Pluck, Recording, Scheme, Start, simulate
from report_page import Reader


def below_fifth(name: str):
    drive = cd.load_drive(name)
    return drive, cd.modes(drive, below=1.05 * cd.natural_frequencies(drive, count=5)[-1])


@pytest.mark.parametrize("name", cd.packaged_drives("loop", "line"))
def test_the_staircase_rises_at_every_listed_mode_and_nowhere_else(name):
    """The count knows nothing of the list, so a missed mode would show as a step without a mode."""
    drive, found = below_fifth(name)
    steps = ladder.staircase(drive, found)
    rises = np.repeat(steps.frequency[1:], np.diff(steps.count).astype(int))
    listed = [mode.frequency for mode in found.longitudinal for _ in range(mode.multiplicity)]
    np.testing.assert_allclose(rises, listed, rtol=2e-9)
    assert steps.count[0] == 0
    assert steps.count[-1] == found.certificate.longitudinal


@pytest.mark.parametrize("name", cd.packaged_drives("loop", "line"))
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


@pytest.mark.parametrize("name", cd.packaged_drives("loop", "line"))
def test_the_drawing_keeps_the_proportions_of_the_machine(name):
    """Spans are tangents of the pulleys, to scale with their carriages; what is stretched is said."""
    drive, sheet = cd.load_drive(name), Sheet()
    drawn = draw_machine(sheet, drive)
    for pulley, own in zip(drawn.pulleys, drive.pulley, strict=True):
        assert pulley.radius / drawn.pulleys[0].radius == pytest.approx(own.radius / drive.pulley[0].radius)
    for span in drawn.spans:
        ends = [np.linalg.norm(end - p.centre) for p in drawn.pulleys for end in span.points[[0, -1]]]
        assert min(abs(end - drawn.pulleys[0].radius) for end in ends) < 1e-6
        assert (span.points[:, 1] < drawn.size[1]).all()
    shares = [c.position / drive.span_length for s in drive.spans for c in drive.carriages_on(s)]
    assert len(re.findall("<rect", "".join(sheet.elements))) == len(shares)


# --- The picture of the modes: a panel for each frequency, with the mode's own shape
@pytest.mark.parametrize("name", cd.packaged_drives("loop", "line"))
def test_every_frequency_has_its_panel(name):
    drive = cd.load_drive(name)
    found = cd.modes(drive, count=6)
    shown = sorted(float(axes.get_title(loc="left").split()[0]) for axes in mode_figure(drive, found).axes)
    listed = [row.frequency for kind in (found.longitudinal, found.transverse) for row in mode_rows(kind)]
    np.testing.assert_allclose(shown, sorted(listed), rtol=1e-4)


def test_shapes_are_those_of_the_modes():
    """Each curve, to its own scale, is proportional to the exact shape."""
    drive = cd.load_drive("dissertation-transporter")
    found = cd.modes(drive, count=4)
    for axes, mode in zip(mode_figure(drive, found).axes, found.longitudinal, strict=False):
        curves = [line.get_xydata() for line in axes.lines if len(line.get_xydata()) > 10]
        assert len(curves) == len(drive.spans)
        drawn = np.concatenate([curve[:, 1] for curve in curves])
        places = [drive.span_length * (curve[:, 0] - start) for start, curve in enumerate(curves)]
        exact = np.concatenate([mode.shape(s, x)[0] for s, x in zip(drive.spans, places, strict=True)])
        slope = float(drawn @ exact / (exact @ exact))
        np.testing.assert_allclose(drawn, slope * exact, atol=1e-9)


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


def test_a_longitudinal_mode_moves_dots_along_their_spans_and_never_off_their_pulleys(idlers):
    """Each dot lies on its span, away from its place at rest by what the mode moves it along."""
    drive, found, axes = idlers
    dots = [
        line.get_xydata() for line in axes[0].lines if line.get_marker() == "o" and len(line.get_xydata()) > 1
    ]
    assert len(dots) == len(drive.free_spans)
    exact = [
        found.longitudinal[0].shape(s.name, np.linspace(0, s.length, POINTS))[0].real
        for s in drive.free_spans
    ]
    shown = drawn_machine(drive)[0]
    size = SIZE * machine_size(shown) / max(np.abs(one).max() for one in exact)
    for own, span, shape in zip(dots, shown.free_spans, exact, strict=True):
        away = np.array(own) - span.contacts[0]
        along = away @ np.array(span.along)
        assert np.abs(away @ np.array((-span.along[1], span.along[0]))).max() < 1e-12
        rest = (np.arange(len(own)) + 0.5) / len(own) * span.length
        moved = rest + size * np.interp(rest, np.linspace(0, span.length, POINTS), shape)
        np.testing.assert_allclose(along, np.clip(moved, 0.0, span.length), atol=1e-9)


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


def test_the_animation_on_a_page_needs_no_script_and_obeys_who_wants_less_motion():
    html = animation_page(DRIVE, run())
    reader = Reader(html)
    assert reader.faults == []
    assert reader.root.all("script") == []
    assert re.findall(r"(?:https?:)?//|url\(|@import", html) == []
    assert "@media (prefers-reduced-motion: reduce)" in html
    (switch,) = reader.root.all("input")
    assert switch.attributes["type"] == "checkbox"
    assert [e.attributes["for"] for e in reader.root.all("label")] == [switch.attributes["id"]]
    assert len(reader.root.all("g")) == len(run().fields)


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
