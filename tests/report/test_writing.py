"""The report appears whole or not at all, and replaces nothing unasked."""

from functools import cache

import pytest

from cabledrive.parameters import NotComputed, load_drive
from cabledrive.report import report_html, write_report, writing
from cabledrive.report.blocks import Chapter, Paragraph
from cabledrive.report.context import make_context
from cabledrive.report.machine.page import machine_view
from report_page import TIME

DRIVES = [load_drive("dissertation-1")]


@pytest.fixture(autouse=True)
def one_study(monkeypatch):
    """What is checked here holds for any studies; this one takes no time."""
    about = Chapter(title="A study", anchor="a-study", blocks=(Paragraph(text="Nothing."),))
    monkeypatch.setattr(writing, "effect_of_parameters", lambda context: about)
    monkeypatch.setattr(writing, "machine_view", lambda context, place: machine())


@cache
def machine():
    """The page of the machine, computed once."""
    return machine_view(make_context(DRIVES), 0)


def test_the_file_is_the_page_with_a_card_for_each_linked_page(tmp_path):
    (tmp_path / "beside").mkdir()
    other = tmp_path / "beside" / "campaign.html"
    other.write_text("<html><head><title>Fleet &amp; field</title></head></html>")
    written = write_report(DRIVES, tmp_path / "report.html", written_at=TIME, links=[other])
    text = written.read_text(encoding="utf-8")
    linked = (("Fleet & field", "beside/campaign.html"),)
    assert text == report_html(DRIVES, written_at=TIME, links=linked)
    assert '<a href="beside/campaign.html">Fleet &amp; field</a>' in text


def test_a_report_that_fails_on_the_way_leaves_nothing(tmp_path, monkeypatch):
    def fail(*args, **kwargs):
        raise NotComputed("no")

    monkeypatch.setattr(writing, "effect_of_parameters", fail)
    with pytest.raises(NotComputed):
        write_report(DRIVES, tmp_path / "report.html")
    assert list(tmp_path.iterdir()) == []
