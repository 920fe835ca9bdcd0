"""Every answer from straight ropes says so where sag would move one of its modes by more than 0.1 %."""

import pytest

import cabledrive as cd
from cabledrive.app.track_text import axis_lines
from cabledrive.reduction.network_axis import as_axis
from cabledrive.report.machine.route_pairs import pairs_of_route
from cabledrive.studies.study.check_stage import _of_the_file
from command import answer, call

WORDS = "sag, which is left out, couples motion along and across"


@pytest.mark.parametrize("name", ["response", "resonance"])
def test_a_response_and_its_pairs_say_that_sag_moves_a_mode(name):
    said = answer(name, "camera-winches")["warnings"]
    assert sum(WORDS in words for words in said) == 1, said
    assert WORDS in call(name, "camera-winches").stdout


def test_the_page_of_a_machine_says_it_of_its_pairs():
    """The modes on the page sag and are certified; the verdict on their pairs rests on straight ropes."""
    drive = cd.load_drive("camera-winches")
    assert cd.modes(drive, below=5.0).certified
    assert any(WORDS in reason for reason in pairs_of_route(drive)[0].reasons)


@pytest.mark.parametrize("name", ["response", "resonance"])
def test_a_tight_belt_is_not_doubted(name):
    assert not any(WORDS in words for words in answer(name, "printer-idlers")["warnings"])


@pytest.mark.parametrize(("pretension", "doubted"), [("4 N", True), ("30 N", False)])
def test_the_chain_of_an_axis_says_that_sag_moves_its_mode(pretension, doubted):
    """At 4 N the belt's first mode is 190 Hz, among the waves across its spans; `modes` takes sag in."""
    loose = [f"cable.pretension={pretension}", "layout.gravity=9.81"]
    drive = cd.load_drive("printer-idlers", overrides=loose)
    axis = as_axis(drive)
    said = axis.words["sag"] or ""
    assert (WORDS in said) == doubted
    assert (WORDS in "\n".join(axis_lines(axis.words))) == doubted
    assert (said in _of_the_file(axis)[1]) == doubted
    found = cd.modes(drive, below=2.0 * axis.words["frequencies_hz"][0])
    assert found.certified
    assert any(mode.model == "shallow sag" for mode in found.transverse)
