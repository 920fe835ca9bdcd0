"""The chapter on learning says what was measured, and nothing of drives that cannot learn."""

from cabledrive.parameters import load_drive
from cabledrive.report.chapters.control_learning import can_learn, chapter, softer
from cabledrive.report.context import ReportContext


def test_drive_without_motor_gets_no_chapter():
    plain = load_drive("dissertation-1")
    assert not can_learn(plain)
    assert chapter(ReportContext(drives=(plain,), routes=(), progress=print)) is None


def test_softer_drive_is_a_tenth_softer_where_the_file_gives_a_stiffness():
    drive = load_drive("dissertation-3")
    assert softer(drive).lumped.cable_stiffness == 0.9 * drive.lumped.cable_stiffness
    bare = load_drive("dissertation-1")
    assert softer(bare) is bare
