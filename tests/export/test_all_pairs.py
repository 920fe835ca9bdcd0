"""Every law on every packaged drive: exported, the self-test passes, or refused as `track` refuses it."""

import shutil

import pytest

import cabledrive as cd
from cabledrive.export import export_to
from cabledrive.rig.laws.registry import CONTROLLERS
from export.compilers import WARNINGS, checked

PAIRS = [(drive, law) for drive in cd.packaged_drives("loop", "line") for law in CONTROLLERS]


@pytest.mark.verify
@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
@pytest.mark.parametrize("drive, law", PAIRS)
def test_a_pair_is_exported_and_passes_or_is_refused_as_track_refuses_it(drive, law, tmp_path):
    refused = None
    try:
        export_to(tmp_path / "out", drive, "c99", controller=law)
    except (cd.InputRefused, cd.NotComputed) as refusal:
        refused = str(refusal)
    if refused is not None:
        with pytest.raises((cd.InputRefused, cd.NotComputed)) as other:
            cd.track(cd.load_drive(drive), controller=law)
        assert "\n" not in refused
        assert refused == str(other.value)
        return
    done = checked(tmp_path / "out", "-O2", *WARNINGS)
    assert done.returncode == 0, done.stdout
