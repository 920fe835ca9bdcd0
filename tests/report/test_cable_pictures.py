"""Pictures and animation of the cable in time show what was computed."""

import re
from functools import cache

import numpy as np
import pytest
from matplotlib.figure import Figure
from report_page import Reader

from cabledrive.modal import natural_frequencies
from cabledrive.parameters import load_drive
from cabledrive.report.animation import animation_page
from cabledrive.report.figures import run_histories
from cabledrive.simulation import Pluck, Recording, Scheme, Start, simulate

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
