"""The page stands alone, is well formed, and can be read by everyone."""

import base64
import json
import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cabledrive.answers.figures import number, quantity
from cabledrive.parameters import NotComputed, load_drive
from cabledrive.report import report_html, write_report, writing
from cabledrive.report.blocks import Chapter, Paragraph
from cabledrive.report.context import make_context
from cabledrive.report.machine.page import machine_view
from cabledrive.report.machine.rest import rest_blocks
from cabledrive.report.picture import COLOURS
from cabledrive.report.typesetting import typeset
from report_page import TIME, Reader, page, read


def attributes(name):
    """Every use of an attribute on the page: element and value."""
    everything = [e for tag in set(re.findall(r"<(\w+)", page())) for e in read().root.all(tag.lower())]
    return [(e.tag, e.attributes[name]) for e in everything if name in e.attributes]


def test_the_page_is_well_formed():
    assert read().faults == []
    assert page().lstrip().startswith("<!DOCTYPE html>")


def test_the_page_refers_to_no_other_file_and_no_network():
    links = [
        value for name in ("href", "src", "xlink:href", "data", "action") for _, value in attributes(name)
    ]
    outside = [value for value in links if not value.startswith("#") and value != "data:,"]
    assert outside == []
    assert re.findall(r"(?:https?:)?//[^\s\"<]+|@import|url\((?!#)", page()) == []


def test_the_data_of_a_plot_are_whole():
    """Every curve of the plot at rest has a value at every point; the tensions are those of the drive."""
    found = re.findall(r'<script type="application/json">(.*?)</script>', page(), re.S)
    plots = {plot["name"]: plot for plot in map(json.loads, found)}
    rest = plots["rest-cable-camera-line"]
    numbers = {
        panel["title"]: np.frombuffer(base64.urlsafe_b64decode(panel["series"][0]["values"]), dtype="<f4")
        for panel in rest["panels"]
    }
    points = np.frombuffer(base64.urlsafe_b64decode(rest["x"]["values"]), dtype="<f4")
    assert points[[0, -1]] == pytest.approx([0.0, 60.144], abs=1e-3)  # with what a drum lets go
    assert all(values.shape == points.shape for values in numbers.values())
    assert all(np.isfinite(values[2:-2]).all() for values in numbers.values())  # some rope lies on its drum
    # 15 kg hang at a third of 60 m under about 1000 N: H y = m g a b / L, plus the weight of the rope
    weight, rope = 15.0 * 9.81, 0.0091 * 9.81
    deep = weight * 20.0 * 40.0 / 60.0 / 1000.0 + rope * 20.0 * 40.0 / 2.0 / 1000.0
    assert -np.nanmin(numbers["Height over the line between its ends"]) == pytest.approx(deep, rel=0.02)
    highest = np.hypot(1000.0, weight * 2 / 3 + rope * 30.0)
    assert np.nanmax(numbers["Tension"]) == pytest.approx(highest, rel=1e-2)


def test_tension_at_rest_of_a_lift_falls_by_the_weight_of_its_rope():
    """Each of its six spans hangs upright: from its lower to its upper end the tension grows by rho g L."""
    drive = load_drive("lift-2-to-1")
    plot, *_ = rest_blocks(drive, "lift")
    assert [panel.title for panel in plot.panels] == ["Tension"]
    assert len(plot.panels[0].series) == len(drive.free_spans) == 6
    for series, span in zip(plot.panels[0].series, drive.free_spans, strict=True):
        values = series.values[np.isfinite(series.values)]
        weight = drive.ropes[span.route].density * 9.81 * span.length * abs(span.along[1])
        assert np.ptp(values) == pytest.approx(weight, rel=0.02), span.name


def test_every_link_leads_to_a_place_on_the_page_and_no_place_has_two_names():
    names = [value for _, value in attributes("id")]
    assert sorted(set(names)) == sorted(names), {name for name in names if names.count(name) > 1}
    inside = [value[1:] for _, value in attributes("href") if value.startswith("#")]
    assert len(inside) > 20
    assert set(inside) <= set(names), set(inside) - set(names)


def test_every_figure_says_what_is_seen_and_what_it_says():
    drawings = [e for e in read().root.all("div") if e.attributes.get("role") == "img"]
    figures = [e for e in read().root.all("figure") if e.attributes.get("class") != "table"]
    assert len(drawings) == len(figures) > 8
    assert [e for e in drawings if len(e.attributes.get("aria-label", "")) < 20] == []
    assert [e for e in read().root.all("figure") if not e.all("figcaption")[0].text] == []


def test_every_table_names_its_columns_and_rows():
    for table in read().root.all("table"):
        assert all(th.attributes.get("scope") for th in table.all("th"))
        columns = len(table.all("thead")[0].all("th"))
        for row in table.all("tbody")[0].all("tr"):
            spans = sum(int(cell.attributes.get("colspan", 1)) for cell in row.children)
            assert spans == columns, row.text


def test_words_of_a_drive_file_are_shown_as_they_are(monkeypatch):
    """What a drive file says is text, never markup; in curves through the fewest values."""
    monkeypatch.setattr(writing, "POINTS", 1)
    name = '</script><script>alert(1)</script> a "quoted" & odd Überseil ü'
    drive = replace(load_drive("camera-line"), name=name, title=name, source=name)
    html = report_html([drive])
    reader = Reader(html)
    assert reader.faults == []
    assert "<script>alert" not in html
    assert reader.root.all("h1")[0].text == name
    assert all(name in e.text for e in reader.root.all("article"))


# --- Numbers, words and colours: customary units, as print has them, readable in light and dark
def plain(text):
    return text.replace("\N{NARROW NO-BREAK SPACE}", " ")


@pytest.mark.parametrize(
    "value, shown",
    [
        (0.0, "0"),
        (-600e-6, "−6 × 10⁻⁴"),
        (116.32932059, "116.33"),
        (1234567.0, "1.2346 × 10⁶"),
        (7.316e-6, "7.316 × 10⁻⁶"),
        (9.999996e-5, "1 × 10⁻⁴"),
        (0.00099999999, "0.001"),
        (float("inf"), "infinite"),
    ],
)
def test_a_number_has_five_digits_and_a_readable_size(value, shown):
    assert plain(number(value)) == shown


@given(st.floats(min_value=1e-25, max_value=1e25), st.booleans(), st.integers(2, 9))
def test_a_shown_number_reads_back_to_its_digits(size, negative, digits):
    value = -size if negative else size
    text = plain(number(value, digits)).replace("−", "-").replace(" × 10", "e")
    text = text.translate(str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-"))
    assert float(text) == pytest.approx(value, rel=0.5000001 * 10.0 ** (1 - digits))


@pytest.mark.parametrize(
    "value, unit, shown",
    [
        (2.6e9, "Pa", "2.6 GPa"),
        (4.9e-4, "kg/m", "0.49 g/m"),
        (0.03, "m", "30 mm"),
        (0.0, "m", "0 m"),
        (114.3539726, "rad/s", "1092 rpm"),
        (-1.5707963267948966, "rad", "−90°"),
        (7.316e-6, "kg m^2", "7.316 × 10⁻⁶ kg m²"),
        (0.0376, "N m", "37.6 mN m"),
        (5.2, "1", "5.2"),
    ],
)
def test_a_quantity_is_shown_in_the_unit_people_use(value, unit, shown):
    assert plain(quantity(value, unit)) == shown


# --- Words are set as print has them; code, formulas and the insides of tags are left alone
N, W = "\N{NARROW NO-BREAK SPACE}", "\N{NO-BREAK SPACE}"


@pytest.mark.parametrize(
    ("plain", "set_"),
    [
        ("raise it to 3.33e+03 N", f"raise it to 3330{N}N"),
        ("7e-08 rad^2 a second", f"7{N}×{N}10⁻⁸{N}rad² a second"),
        ("b = -0.0021 N m s/rad", f"b = −0.0021{N}N{W}m{W}s/rad"),
        ("2 r1 T0 over J11", "2 r₁ T₀ over J₁₁"),
        ("a floor of 10 um", f"a floor of 10{N}µm"),
        ("right to 5 % and", f"right to 5{N}% and"),
    ],
)
def test_words_are_set_as_print_has_them(plain, set_):
    assert typeset(f"<p>{plain}</p>") == f"<p>{set_}</p>"


@pytest.mark.parametrize(
    "html",
    [
        '<a href="#fig-4-17-r1" title="T0 of 5 N">Figures 5-6, darc-4, 3 moves and 2 spans</a>',
        "<code>9c83e05 motor.r1 = 5 N, 1e-3</code>",
        "<style>.a { margin: -2px 1e3px }</style><script>const r1 = -2 ** 1e-3;</script>",
        "<math><mi>T0</mi><mo>-5</mo></math>",
    ],
)
def test_code_formulas_and_tags_are_left_alone(html):
    assert typeset(html) == html


# --- Colours can be read and distinguished, in light and in dark
WORDS = ("ink", "quiet", "blue", "orange", "green", "purple", "ochre", "red")


def luminance(colour):
    parts = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    linear = (p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts)
    return sum(w * p for w, p in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


@pytest.mark.parametrize("theme", [0, 1], ids=["light", "dark"])
@pytest.mark.parametrize("ground", ["paper", "card", "faint"])
@pytest.mark.parametrize("word", WORDS)
def test_words_reach_the_contrast_of_readable_text(word, ground, theme):
    """4.5 to 1, level AA of the Web Content Accessibility Guidelines."""
    low, high = sorted(luminance(COLOURS[name][theme]) for name in (word, ground))
    seen = (high + 0.05) / (low + 0.05)
    assert seen >= 4.5, f"{word} on {ground}: {seen:.2f}"


# --- The report appears whole or not at all, and replaces nothing unasked
DRIVES = [load_drive("dissertation-1")]


@pytest.fixture
def one_study(monkeypatch):
    """What is checked here holds for any studies; this one takes no time."""
    about = Chapter(title="A study", anchor="a-study", blocks=(Paragraph(text="Nothing."),))
    monkeypatch.setattr(writing, "effect_of_parameters", lambda context: about)
    monkeypatch.setattr(writing, "machine_view", lambda context, place: machine())


@cache
def machine():
    """The page of the machine, computed once."""
    return machine_view(make_context(DRIVES), 0)


def test_the_file_is_the_page_with_a_card_for_each_linked_page(one_study, tmp_path):
    (tmp_path / "beside").mkdir()
    other = tmp_path / "beside" / "campaign.html"
    other.write_text("<html><head><title>Fleet &amp; field</title></head></html>")
    written = write_report(DRIVES, tmp_path / "report.html", written_at=TIME, links=[other])
    text = written.read_text(encoding="utf-8")
    linked = (("Fleet & field", "beside/campaign.html"),)
    assert text == report_html(DRIVES, written_at=TIME, links=linked)
    assert '<a href="beside/campaign.html">Fleet &amp; field</a>' in text


def test_a_report_that_fails_on_the_way_leaves_nothing(one_study, tmp_path, monkeypatch):
    def fail(*args, **kwargs):
        raise NotComputed("no")

    monkeypatch.setattr(writing, "effect_of_parameters", fail)
    with pytest.raises(NotComputed):
        write_report(DRIVES, tmp_path / "report.html")
    assert list(tmp_path.iterdir()) == []
