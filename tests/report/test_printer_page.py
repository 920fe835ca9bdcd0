"""A printer's page: files by their names, peaks of known modes, belts compared; figures of every page."""

import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure
from reproduction.bench import BENCH_TESTS, bench_command, bench_rig

import cabledrive as cd
from cabledrive.answers.figures import MOST_PARTS
from cabledrive.identification.axis.axis import AxisOptions, axis_of
from cabledrive.identification.printer import belt_of, is_printer_file, printer
from cabledrive.mechanics.datasheet import derived_quantities
from cabledrive.modal.mode_rows import mode_rows
from cabledrive.parameters import InputRefused, load_drive
from cabledrive.reduction.network_axis import as_axis
from cabledrive.report.animation import animation_svg, controlled_film
from cabledrive.report.figures import run_histories
from cabledrive.report.figures.ladder import staircase
from cabledrive.report.figures.shapes import FEWEST
from cabledrive.report.log_page import write_log_report
from cabledrive.report.machine.data import OF_ONE_ROPE, data_sheet, data_table
from cabledrive.report.mode_figure import mode_figure, mode_picture
from cabledrive.report.printer_page import printer_html
from cabledrive.report.printer_tables import computed
from cabledrive.rig import Motion, track
from cabledrive.rig.virtual_rig import Imperfections, run_rig
from cabledrive.simulation import Pluck, Recording, Scheme, Start, simulate
from cabledrive.simulation.signals import Sine
from command import answer, refusal
from network_samples import as_routes
from printer_logs import samples, write_densities, write_samples
from report_page import TIME, Reader

TRUTH = {"x": 61.0, "y": 48.0, "a": 52.0, "b": 58.0}
NAMES = {
    "x": "raw_data_x_20260102_030405.csv",
    "y": "inputshaper_20260102_030405_Y.csv",
    "a": "raw_data_axis=1.000,-1.000_20260102.csv",
    "b": "belts_20260102_030405_B.csv",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place, rng = tmp_path_factory.mktemp("printer"), np.random.default_rng(5)
    for name, hertz in TRUTH.items():
        write = write_samples if name == "x" else write_densities
        write(place / NAMES[name], samples([(hertz, 0.05, 1.0)], rng))
    return place


@pytest.mark.parametrize(
    ("name", "belt", "test"),
    [
        ("raw_data_axis=1.000,-1.000_a.csv", "a", True),
        ("resonances_axis=1.000,1.000_20260102_030405.csv", "b", True),
        ("belt_20230604_120000_A.csv", "a", True),
        ("belts_20240511_191024_B.csv", "b", True),
        ("belt_b.csv", "b", True),
        ("resonances_x_20260102_030405.csv", None, True),
        ("calibration_data_y_20260102.csv", None, True),
        ("belt-a.wav", "a", False),
        ("my_log_a.csv", None, False),
        ("seatbelt.csv", None, False),
    ],
)
def test_belts_and_tests_are_told_by_their_names(name, belt, test):
    assert (belt_of(name), is_printer_file(name)) == (belt, test)


def test_the_page_has_the_modes_that_the_logs_were_made_of_beside_those_of_the_machine(folder, measured):
    found = printer([folder / name for name in NAMES.values()])
    assert [axis.axis for axis in found.axes] == ["x", "y"]
    for axis in found.axes:
        assert axis.peaks[0].frequency == pytest.approx(TRUTH[axis.axis], abs=0.5)
    off = max(abs(axis.peaks[0].frequency - TRUTH[axis.axis]) for axis in found.axes)
    measured(f"peaks within {off:.2f} Hz, belts {found.belts.difference:.2f} Hz apart for -6")
    assert found.belts.difference == pytest.approx(TRUTH["a"] - TRUTH["b"], abs=0.5)
    html = printer_html(found, load_drive("corexy"))
    own = computed(load_drive("corexy"), "x")
    assert f"{own['head.x']:.1f}" in html
    for axis in found.axes:
        assert axis.configuration in html
    assert re.search(r"loosen belt B", html)
    assert html.count('id="sweep-x-0"') == 1
    assert "sweep-y-0" not in html


def test_alike_belts_are_called_equally_tight(tmp_path):
    for name in "ab":
        write_densities(
            tmp_path / f"belt_{name}.csv", samples([(55.0, 0.05, 1.0)], np.random.default_rng(ord(name)))
        )
    found = printer([tmp_path / "belt_a.csv", tmp_path / "belt_b.csv"])
    assert found.belts.similarity > 0.99
    assert "equally tight" in printer_html(found)


def test_the_command_writes_the_page_and_lines_of_both_axes(folder, monkeypatch):
    """Beside a loop stands what its carriage does on belts without mass and a motor that holds, to 3 %."""
    monkeypatch.chdir(folder)
    data = answer("shaper", *NAMES.values(), "--page", "printer.html", "--machine", "corexy", "-o", "p.json")
    assert [one["axis"] for one in data["axes"]] == ["x", "y"]
    answer("export", "p.json", "--format", "klipper", "-o", "lines")
    assert (folder / "lines" / "printer.cfg").read_text().count("shaper_freq_") == 2
    answer("shaper", NAMES["x"], "--page", "belt.html", "--machine", "printer-belt")
    belt, (motor,) = load_drive("printer-belt").listed, load_drive("printer-belt").listed.motors
    ways = belt.carriage[0].position, 2.0 * belt.span_length - belt.carriage[0].position
    held = motor.holding_stiffness / belt.drive_pulley.radius**2
    stiffness = 1.0 / (1.0 / sum(belt.cable.axial_rigidity / way for way in ways) + 1.0 / held)
    own = computed(belt.machine, "x")["carriage 0"]
    assert own == pytest.approx(np.sqrt(stiffness / belt.carriage[0].mass) / (2.0 * np.pi), rel=0.03)
    assert f"{own:.1f}" in (folder / "belt.html").read_text()
    assert "the other belt" in refusal("shaper", NAMES["a"], "--page", "q.html")
    assert "--axis" in refusal("shaper", NAMES["x"], "--axis", "x", "--page", "q.html")
    assert "--page" in refusal("shaper", NAMES["x"], "--machine", "corexy")


# --- Somebody's own log becomes a page with its numbers and its data check
def test_the_page_is_sound_and_says_what_was_found(tmp_path):
    test, rng = replace(BENCH_TESTS[1], duration=12.0), np.random.default_rng(5)
    log = run_rig(bench_rig(test, Imperfections(torque_noise=0.002)), bench_command(test, rng), rng)
    found = axis_of([log], AxisOptions()).regressed()
    (tmp_path / "a.csv").write_text("x")
    path = write_log_report(log, found, tmp_path / "a.html", files=[tmp_path / "a.csv"], written_at=TIME)
    page = Reader(path.read_text(encoding="utf-8"))
    assert page.faults == []
    assert sum("table" not in f.attributes.get("class", "") for f in page.root.all("figure")) == 2
    words = page.root.text
    for expected in ("coulomb friction", "12000 rows", "no repairs", "a.csv", "Residual"):
        assert expected in words, expected
    with pytest.raises(InputRefused, match="exists"):
        write_log_report(log, found, tmp_path / "a.html")


# --- What the figures draw is what was computed
def test_a_mode_of_two_belts_is_drawn_along_each_span_in_order():
    """Displacements over the largest of all, lengths over those of both belts, with a gap between them."""
    drive = cd.load_drive("corexy")
    found = cd.modes(drive, count=2)
    for axes, rows in zip(
        mode_figure(drive, found, most=1).axes, (found.longitudinal, found.transverse), strict=True
    ):
        curves = [line.get_xydata() for line in axes.lines if len(line.get_xydata()) >= FEWEST]
        mode, whole, gap = mode_rows(rows)[0].modes[0], sum(span.length for span in drive.free_spans), 0.0
        places = [
            np.linspace(0.0, span.length, len(own))
            for span, own in zip(drive.free_spans, curves, strict=True)
        ]
        exact = [mode.shape(one.name, at)[0] for one, at in zip(drive.free_spans, places, strict=True)]
        size = max(np.concatenate(exact), key=abs)
        starts = np.cumsum([0.0, *(span.length for span in drive.free_spans)]) / whole
        for curve, own, at, start, span in zip(curves, exact, places, starts, drive.free_spans, strict=False):
            gap = 0.06 * span.route
            np.testing.assert_allclose(curve[:, 0], start + gap + at / whole)
            np.testing.assert_allclose(curve[:, 1], own / size, atol=1e-9)
        assert gap > 0.0
    assert mode_picture(drive, found, "svg", most=1).startswith(b"<?xml")


# --- Pictures and animation of the cable in time
DRIVE = cd.load_drive("dissertation-2").listed


def test_the_spectrum_marks_the_certified_modes():
    marks = run_histories.spectrum_marks(DRIVE.machine)
    longitudinal = [frequency for frequency, kind in marks if kind == "longitudinal"]
    assert longitudinal == [pytest.approx(cd.natural_frequencies(DRIVE, count=1)[0])]
    transverse = [frequency for frequency, kind in marks if kind == "transverse"]
    # the sag parts the planes and couples the spans, by less than 2e-5
    orders = np.rint(np.array(transverse) / transverse[0])
    assert set(orders) == {1, 2, 3, 4}
    np.testing.assert_allclose(transverse, transverse[0] * orders, rtol=1e-4)
    start, axes = Start(plucks=(Pluck(height=2e-3),)), Figure().add_subplot()
    recording = Recording(rate=10_000.0)
    run = simulate(DRIVE, 0.05, start=start, scheme=Scheme(segments=20), recording=recording)
    run_histories.draw_spectrum(axes, run, marks)
    assert sorted(line.get_xdata()[0] for line in axes.lines[1:]) == [frequency for frequency, _ in marks]


def test_the_count_of_a_machine_with_routes_steps_at_each_listed_mode():
    drive = cd.load_drive("corexy")
    found = cd.modes(drive, below=560.0)
    steps = staircase(drive, found)
    along = np.repeat([m.frequency for m in found.longitudinal], [m.multiplicity for m in found.longitudinal])
    np.testing.assert_array_equal(steps.count, np.searchsorted(along, steps.frequency))
    assert steps.count[-1] == 6


# --- The film of a controlled run: every picture shows the run at its time
def test_every_picture_says_the_error_at_its_time():
    drive, motion = cd.load_drive("dissertation-3").listed, Motion(angle=15.0, rise=0.2, dwell=0.05)
    found = track(drive, controller="pd", bandwidth=20.0, plant="model-3", motion=motion)
    page = controlled_film(drive, found)
    said = re.findall(r">(\d+\.\d+) s, error (-?[\d.]+) deg<", page)
    assert len(said) == 64
    for time, error in said:
        at = np.abs(found.time - float(time)) <= 0.0005 + 1e-9
        errors = np.degrees(found.error[at])
        assert errors.min() - 1e-4 <= float(error) <= errors.max() + 1e-4
    assert float(said[-1][0]) == pytest.approx(found.time[-1], abs=5e-4)


def test_a_film_of_a_sliding_load_says_the_error_in_length():
    drive, motion = as_axis(cd.load_drive("corexy")), Motion(angle=60.0, rise=0.2, dwell=0.05)
    found = track(drive, controller="pd", bandwidth=10.0, plant="model-3", motion=motion)
    page = controlled_film(drive, found)
    said = re.findall(r">(\d+\.\d+) s, error (-?[\d.]+) mm<", page)
    assert len(said) == 64
    millimetres = 1e3 * abs(drive.axis.per_angle) * found.error
    for time, error in said:
        at = np.abs(found.time - float(time)) <= 0.0005 + 1e-9
        assert millimetres[at].min() - 1e-4 <= float(error) <= millimetres[at].max() + 1e-4


def bend(path):
    """Largest distance of the points of a drawn line from that between its ends [px]."""
    points = np.array([[float(value) for value in own.split()] for own in path[1:].split(" L")])
    (x, y), chord = (points - points[0]).T, points[-1] - points[0]
    return np.abs(chord[0] * y - chord[1] * x).max() / np.hypot(*chord)


def test_an_animation_of_routes_draws_each_rope_as_far_aside_as_it_is():
    """A plucked span of a printer: 26 px at most, and in each frame in proportion to the record."""
    drive, span = cd.load_drive("printer-idlers"), "motor to lower idler"
    start = Start(plucks=(Pluck(height=1e-3, span=span, shape="half-sine"),))
    run = simulate(drive, 4e-3, start=start, scheme=Scheme(segments=20), recording=Recording(fields=2))
    _, drawing = animation_svg("machine", drive, run)
    frames = drawing.split('-frame" style')[1:]
    own = run.spans.index(span)
    first = sum(len(places) for places in run.positions[:own])
    truth = np.abs(run.fields[:, 2, first : first + len(run.positions[own])]).max(axis=1)
    drawn = [
        max(map(bend, re.findall(r'd="(M[^"]+)" style="fill: none; stroke: var\(--(?:blue|orange)', frame)))
        for frame in frames
    ]
    assert len(frames) == truth.size > 10
    np.testing.assert_allclose(drawn, 26.0 * truth / truth.max(), atol=0.2)


def test_an_animation_moves_what_a_body_carries_with_it():
    """Pulleys of the beam of a CoreXY with the beam, anchors of the head with it, to a tenth of a pixel."""
    drive = cd.load_drive("corexy")
    torque = {"motor a": Sine(amplitude=0.1, frequency=58.0)}
    run = simulate(drive, 0.02, torque=torque, scheme=Scheme(segments=10), recording=Recording(fields=20))
    frames = animation_svg("machine", drive, run)[1].split('-frame" style')[1:]

    def places(mark):
        found = [re.findall(mark, frame) for frame in frames]
        return np.array(found, dtype=float) - np.array(found[:1], dtype=float)

    carried = places(r'<circle cx="([^"]+)" cy="([^"]+)" r="[^"]+" style="[^"]*(?:quiet|ink)')
    bodies = places(r'<rect x="([^"]+)" y="([^"]+)"')
    parts = [own.on for own in (*drive.pulley, *drive.anchor) if own.on]
    names = [body.name for body in drive.body]
    for own, way in zip(parts, carried.transpose(1, 0, 2), strict=True):
        np.testing.assert_allclose(way, bodies[:, names.index(own)], atol=0.11)
    assert np.abs(bodies).max() > 20.0


@pytest.mark.parametrize("name", ["dissertation-3", "dissertation-2"])
def test_a_machine_with_routes_has_the_closed_formulas_of_the_loop_that_it_is(name):
    loop = cd.load_drive(name).listed
    machine = as_routes(loop if loop.motor else replace(loop, motor=cd.Motor(inertia=1e-6)))
    known, found = derived_quantities(loop).as_dict(), data_sheet(machine).derived
    for key in (*OF_ONE_ROPE, "cable_mass", "static_sag", "slack_torque"):
        assert found[key] == pytest.approx(known[key], rel=2e-3), key


def test_what_a_machine_with_routes_has_not_is_none_with_a_reason():
    found = data_sheet(cd.load_drive("lift-2-to-1")).derived
    for key in ("axial_rigidity", "slack_torque"):
        assert found[key] is None
        assert found["reasons"][key]


@pytest.mark.parametrize("name", ["printer-idlers", "corexy", "elevator"])
def test_the_page_of_a_machine_lists_what_its_file_says_of_each_part(name):
    drive = load_drive(name).listed
    titles = [group.title for group in data_table(drive).groups]
    for kind in ("pulley", "motor", "carriage", "body"):
        parts = getattr(drive, kind, ()) or ()
        several = parts if isinstance(parts, tuple) else (parts,)
        found = [title for title in titles if title.split()[0].lower() == kind]
        assert len(found) == min(len(several), MOST_PARTS), kind
