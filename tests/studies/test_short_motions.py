"""A motion that ends before the pulley mode has turned once is judged like any other."""

import pytest

from cabledrive import load_drive
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.studies.alarm import alarm
from cabledrive.studies.motion_file import read_motion


def test_a_motion_of_a_millisecond_is_judged(tmp_path):
    """A ninth of a period cannot excite: what is there at the end is the floor and hardly more."""
    path = tmp_path / "move.csv"
    path.write_text("time [ms],torque [mN m],pretension [N],carriage [mm]\n0,0,3.30,250\n1,4.2,3.30,250\n")
    found = alarm(load_drive("dissertation-transporter"), read_motion(path), floor=1e-5, limit=5e-4)
    largest = max(mode.largest for mode in found.modes)
    assert found.verdict == "safe"
    assert 1e-5 < largest < 1.2e-5, largest
    assert all(0.0 <= mode.time <= 1e-3 for mode in found.modes)


def test_a_motion_beyond_any_number_is_not_a_defect(tmp_path):
    """Growth between two edges that no double holds; the torque of such a motion is no machine's."""
    path = tmp_path / "move.csv"
    path.write_text("time [s],torque [N m]\n" + "".join(f"{k / 100},{1e9 * (-1) ** k}\n" for k in range(100)))
    with pytest.raises(NotComputed, match="diverges: plan a smaller or a slower motion"):
        alarm(load_drive("dissertation-2"), read_motion(path), floor=1e-5, limit=5e-4)


def test_a_motion_file_with_a_column_twice_is_refused(tmp_path):
    (tmp_path / "twice.csv").write_text("time [s],torque [N m],Torque [N m]\n0,1,2\n1,1,2\n")
    with pytest.raises(InputRefused, match="two columns have one name"):
        read_motion(tmp_path / "twice.csv")
