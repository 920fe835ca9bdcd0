"""A cable by its axial rigidity is the cable by modulus and area of the same product."""

import pytest

import cabledrive as cd
from cabledrive.parameters import drive_text, load_drive
from cabledrive.reduction.quality import with_measured_stiffness

RIGID = 'axial_rigidity = "19.4 kN"'


@pytest.fixture
def sheet(tmp_path):
    """The packaged printer drive with the belt's rigidity as its data sheet has it."""
    text = drive_text(load_drive("printer-belt"))
    lines = [line for line in text.splitlines() if not line.startswith(("youngs_modulus", "area"))]
    path = tmp_path / "belt.toml"
    path.write_text("\n".join(lines).replace("[cable]", f"[cable]\n{RIGID}"))
    return path


def test_modes_are_those_of_modulus_and_area(sheet):
    drive, pair = load_drive(sheet), load_drive("printer-belt", overrides=["cable.youngs_modulus=5.132275e9"])
    assert drive.cable.axial_rigidity == 19400.0
    assert pair.cable.axial_rigidity == pytest.approx(19400.0, rel=1e-6)
    ours, theirs = (cd.natural_frequencies(each, count=4) for each in (drive, pair))
    assert ours == pytest.approx(theirs, rel=1e-6)


def test_a_measured_stiffness_takes_its_place(sheet):
    drive = load_drive(sheet, overrides=["lumped.cable_stiffness=40000"])
    measured = with_measured_stiffness(drive)
    assert measured.cable.axial_rigidity / measured.span_length == pytest.approx(40000.0, rel=1e-14)
