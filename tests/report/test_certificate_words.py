"""What a report says of a list of modes, certified or not."""

from dataclasses import replace

import pytest

from cabledrive.modal import modes
from cabledrive.modal.model_range import INCOMPLETE
from cabledrive.parameters import load_drive
from cabledrive.report.certificate_words import certificate_words

FOUND = modes(load_drive("dissertation-2"), below=120.0)


@pytest.mark.parametrize(("certified", "words"), [(True, "All are listed"), (False, "may be incomplete")])
def test_a_certificate_gives_count_verdict_and_the_rigid_body_mode(certified, words):
    reason = None if certified else INCOMPLETE
    said = certificate_words(replace(FOUND, certified=certified, certified_reason=reason))
    assert "exactly nine natural modes: 1 longitudinal and 8 transverse" in said
    assert words in said
    assert "one rigid-body mode (0 Hz)" in said
