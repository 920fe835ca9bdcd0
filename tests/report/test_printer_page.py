"""One page for a printer: files by their names, peaks of known modes, belts against each other."""

import re

import numpy as np
import pytest
from reproduction.bench import BENCH_TESTS, bench_command, bench_rig

from cabledrive.identification.axis.axis import AxisOptions, axis_of
from cabledrive.identification.printer import belt_of, is_printer_file, printer
from cabledrive.parameters import InputRefused, load_drive
from cabledrive.report.log_page import write_log_report
from cabledrive.report.printer_page import printer_html
from cabledrive.report.printer_tables import computed
from cabledrive.rig.virtual_rig import Imperfections, run_rig
from command import answer, refusal
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
    monkeypatch.chdir(folder)
    data = answer("shaper", *NAMES.values(), "--page", "printer.html", "--machine", "corexy", "-o", "p.json")
    assert [one["axis"] for one in data["axes"]] == ["x", "y"]
    answer("export", "p.json", "--format", "klipper", "-o", "lines")
    assert (folder / "lines" / "printer.cfg").read_text().count("shaper_freq_") == 2
    assert "the other belt" in refusal("shaper", NAMES["a"], "--page", "q.html")
    assert "--axis" in refusal("shaper", NAMES["x"], "--axis", "x", "--page", "q.html")
    assert "--page" in refusal("shaper", NAMES["x"], "--machine", "corexy")


# --- Somebody's own log becomes a page with its numbers and its data check
@pytest.fixture(scope="module")
def log():
    from dataclasses import replace

    test, rng = replace(BENCH_TESTS[1], duration=12.0), np.random.default_rng(5)
    return run_rig(bench_rig(test, Imperfections(torque_noise=0.002)), bench_command(test, rng), rng)


@pytest.fixture(scope="module")
def found(log):
    return axis_of([log], AxisOptions()).regressed()


def test_the_page_is_sound_and_says_what_was_found(log, found, tmp_path):
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
