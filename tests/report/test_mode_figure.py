"""The picture of the modes shows what the list holds: a rung for each frequency, and the mode's own shape."""

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.modal.mode_rows import mode_rows
from cabledrive.report.figures.shapes import POINTS, SIZE, machine_size
from cabledrive.report.mode_figure import mode_figure, mode_picture, route_mode_figure


def panels(name, count=6, most=10):
    """The modes of a drive, and the panels that show them by kind."""
    drive = cd.load_drive(name)
    found = cd.modes(drive, count=count)
    axes = mode_figure(drive, found, most=most).axes
    return drive, found, {axis.get_title(loc="left").split()[0]: axis for axis in axes}


def rungs(axis):
    """Frequencies of the rungs: the level lines that start at the left edge."""
    lines = [line.get_xydata() for line in axis.lines]
    return sorted(xy[0, 1] for xy in lines if xy.shape == (2, 2) and xy[0, 0] == 0.0 and xy[0, 1] == xy[1, 1])


@pytest.mark.parametrize("name", cd.packaged_drives("loop", "line"))
def test_every_frequency_has_its_rung(name):
    _, found, shown = panels(name)
    for kind, axis in shown.items():
        rows = mode_rows([mode for mode in found.modes if mode.kind == kind])
        assert rungs(axis) == [row.frequency for row in rows]


def test_shapes_are_those_of_the_modes():
    """Each curve, about its line of rest and to its own scale, is proportional to the exact shape."""
    drive, found, shown = panels("dissertation-transporter", count=4)
    curves = [line.get_ydata() for line in shown["longitudinal"].lines if len(line.get_ydata()) > 10]
    assert len(curves) == 2 * 4  # two spans each
    positions = np.linspace(0.0, drive.span_length, len(curves[0]))
    for number, mode in enumerate(found.longitudinal):
        drawn = np.concatenate(curves[2 * number : 2 * number + 2])
        exact = np.concatenate([mode.shape(span, positions)[0] for span in drive.spans])
        slope, rest = np.polyfit(exact, drawn, 1)
        assert slope > 0.0
        np.testing.assert_allclose(drawn, rest + slope * exact, atol=1e-9 * np.ptp(drawn))


@pytest.fixture(scope="module")
def idlers():
    drive = cd.load_drive("printer-idlers")
    found = cd.modes(drive, count=2)
    return drive, found, route_mode_figure(drive, found, most=1).axes


def test_a_transverse_mode_of_a_machine_with_routes_is_drawn_across_its_spans(idlers):
    """The drawn displacement of each span, over the largest of all, is that of the mode."""
    drive, found, axes = idlers
    curves = [np.array(line.get_xydata()) for line in axes[1].lines if len(line.get_xydata()) == POINTS]
    assert len(curves) == len(drive.free_spans)
    mode, drawn, exact = mode_rows(found.transverse)[0].modes[0], [], []
    for curve, span in zip(curves, drive.free_spans, strict=True):
        rest = np.array(span.contacts[0]) + np.outer(np.linspace(0, span.length, POINTS), span.along)
        drawn.append((curve - rest) @ np.array((-span.along[1], span.along[0])))
        exact.append(np.real(mode.shape(span.name, np.linspace(0, span.length, POINTS))[0]))
    drawn, exact = np.concatenate(drawn), np.concatenate(exact)
    size = SIZE * machine_size(drive)
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
    size = SIZE * machine_size(drive) / max(np.abs(one).max() for one in exact)
    for own, span, shape in zip(dots, drive.free_spans, exact, strict=True):
        away = np.array(own) - span.contacts[0]
        along = away @ np.array(span.along)
        assert np.abs(away @ np.array((-span.along[1], span.along[0]))).max() < 1e-12
        rest = (np.arange(len(own)) + 0.5) / len(own) * span.length
        moved = rest + size * np.interp(rest, np.linspace(0, span.length, POINTS), shape)
        np.testing.assert_allclose(along, np.clip(moved, 0.0, span.length), atol=1e-9)
