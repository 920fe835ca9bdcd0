"""Pictures and animation of the cable in time show what was computed."""

import re
from functools import cache

import numpy as np
import pytest
from matplotlib.figure import Figure

from cabledrive.modal import natural_frequencies
from cabledrive.parameters import load_drive
from cabledrive.report.animation import animation_page, controlled_film
from cabledrive.report.figures import run_histories
from cabledrive.rig import Motion, track
from cabledrive.simulation import Pluck, Recording, Scheme, Start, simulate
from report_page import Reader

DRIVE = load_drive("dissertation-2")


@cache
def run(fields: int = 20):
    plucks = (Pluck(height=2e-3), Pluck(height=1e-3, span="lower"), Pluck(height=1e-3, plane="v"))
    return simulate(
        DRIVE,
        0.05,
        start=Start(plucks=plucks),
        scheme=Scheme(segments=20),
        recording=Recording(rate=10_000.0, fields=fields),
    )


def test_the_spectrum_marks_the_certified_modes():
    marks = run_histories.spectrum_marks(DRIVE)
    longitudinal = [frequency for frequency, kind in marks if kind == "longitudinal"]
    assert longitudinal == [pytest.approx(natural_frequencies(DRIVE, count=1)[0])]
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
    assert len(reader.root.all("g")) == 2 * len(run().fields)  # a drawing for wide pages, one for narrow ones


# --- The film of a controlled run: every picture shows the run at its time
def test_every_picture_says_the_error_at_its_time():
    drive, motion = load_drive("dissertation-3"), Motion(angle=15.0, rise=0.2, dwell=0.05)
    found = track(drive, controller="pd", bandwidth=20.0, plant="model-3", motion=motion)
    page = controlled_film(drive, found)
    said = re.findall(r">(\d+\.\d+) s, error (-?[\d.]+) deg<", page)
    assert len(said) == 2 * 64  # wide and narrow
    for time, error in said:
        at = np.abs(found.time - float(time)) <= 0.0005 + 1e-9
        errors = np.degrees(found.error[at])
        assert errors.min() - 1e-4 <= float(error) <= errors.max() + 1e-4
    assert float(said[-1][0]) == pytest.approx(found.time[-1], abs=5e-4)
