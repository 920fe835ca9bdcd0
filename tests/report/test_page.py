"""The page stands alone, is well formed, and can be read by everyone."""

import base64
import html
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from cabledrive.parameters import load_drive
from cabledrive.report import report_html
from report_page import Reader, page, read


def attributes(name: str) -> list[tuple[str, str]]:
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


def test_the_only_script_is_the_page_s_own():
    """It shows one page of the report at a time, values under a pointer, curves; the rest are their data."""
    scripts = read().root.all("script")
    assert [e.attributes for e in scripts if e.attributes.get("type") != "application/json"] == [{}]
    assert [name for name in re.findall(r"\s(on\w+)=", page())] == []
    read_without = re.sub(r"<script\b.*?</script>", "", page(), flags=re.S)
    assert Reader(read_without).root.all("figure") != []


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
    assert points[[0, -1]].tolist() == [0.0, 60.0]
    assert all(values.shape == points.shape and np.isfinite(values).all() for values in numbers.values())
    # 15 kg hang at a third of 60 m under about 1000 N: H y = m g a b / L, plus the weight of the rope
    weight, rope = 15.0 * 9.81, 0.0091 * 9.81
    deep = weight * 20.0 * 40.0 / 60.0 / 1000.0 + rope * 20.0 * 40.0 / 2.0 / 1000.0
    assert -numbers["Height over the line of the pulleys"].min() == pytest.approx(deep, rel=0.01)
    assert numbers["Tension"].max() == pytest.approx(np.hypot(1000.0, weight * 2 / 3 + rope * 30.0), rel=1e-3)


def test_every_plot_says_where_its_axes_lie_and_what_they_measure():
    """Ends on the picture inside its frame; limits in order along them, above zero where by ratios."""
    pictures = re.findall(r'<svg viewBox="0 0 ([\d.]+) ([\d.]+)"[^>]* data-axes="([^"]*)"', page())
    assert len(pictures) > 4
    for width, height, described in pictures:
        for scales in json.loads(html.unescape(described)):
            for name, length in (("x", float(width)), ("y", float(height))):
                first, last, *measures = scales[name]
                assert -1.0 <= min(first, last) < max(first, last) <= length + 1.0
                if measures:
                    low, high, logarithmic, _ = measures
                    assert low != high
                    assert not logarithmic or low * high > 0.0


def test_every_link_leads_to_a_place_on_the_page_and_no_place_has_two_names():
    names = [value for _, value in attributes("id")]
    assert sorted(set(names)) == sorted(names), {name for name in names if names.count(name) > 1}
    inside = [value[1:] for _, value in attributes("href") if value.startswith("#")]
    assert len(inside) > 20
    assert set(inside) <= set(names), set(inside) - set(names)


def test_every_figure_says_what_is_seen_and_what_it_says():
    drawings = [e for e in read().root.all("div") if e.attributes.get("role") == "img"]
    figures = [e for e in read().root.all("figure") if e.attributes.get("class") != "table"]
    plots = [e for e in drawings if e.attributes["class"] == "plot"]
    # each drawing for wide and for narrow pages
    assert len(drawings) == 2 * (len(figures) - len(plots)) + len(plots) > 12
    assert [e for e in drawings if len(e.attributes.get("aria-label", "")) < 20] == []
    assert [e for e in read().root.all("figure") if not e.all("figcaption")[0].text] == []


def test_every_table_names_its_columns_and_rows():
    for table in read().root.all("table"):
        assert all(th.attributes.get("scope") for th in table.all("th"))
        columns = len(table.all("thead")[0].all("th"))
        for row in table.all("tbody")[0].all("tr"):
            spans = sum(int(cell.attributes.get("colspan", 1)) for cell in row.children)
            assert spans == columns, row.text


def test_words_of_a_drive_file_are_shown_as_they_are():
    """What a drive file says is text, never markup."""
    name = '</script><script>alert(1)</script> a "quoted" & odd Überseil ü'
    drive = replace(load_drive("camera-line"), name=name, title=name, source=name)
    html = report_html([drive])
    reader = Reader(html)
    assert reader.faults == []
    assert "<script>alert" not in html
    assert reader.root.all("h1")[0].text == name
    assert all(name in e.text for e in reader.root.all("article"))
