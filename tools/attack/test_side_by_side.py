"""Two to eight processes on one run: one works, the others are refused; and places that cannot be written."""

import os
import shutil
import sys
from pathlib import Path

import pytest

from attack.moments import RUN
from attack.nursery import Nursery
from command import run

pytestmark = pytest.mark.verify
REFUSED = ("another process works there", "exists and is not overwritten", "left by an interrupted run")
REFUSED += ("was written meanwhile by another process",)


@pytest.fixture(scope="module")
def nursery():
    if not sys.platform.startswith("linux"):
        pytest.skip("needs fork and files in memory")
    with Nursery() as ready:
        yield ready


@pytest.mark.parametrize("option", [[], ["--resume"]], ids=["plain", "resume"])
def test_of_processes_that_write_one_run_one_works(nursery, tmp_path, option, measured):
    alone = nursery.run(*RUN, "-o", "alone.nc", folder=tmp_path)
    assert alone.status == 0, alone
    found = []
    for number in range(2, 9):
        place = tmp_path / f"{number}"
        place.mkdir()
        ended = nursery.run_all([[*RUN, *option, "-o", "r.nc"]] * number, folder=place, seconds=300.0)
        found.append((number, sum(one.status == 0 for one in ended)))
        for one in ended:
            assert one.status in (0, 2), one
            assert one.status == 0 or any(words in one.line for words in REFUSED), one.line
        assert (place / "r.nc").read_bytes() == (tmp_path / "alone.nc").read_bytes()
        assert os.listdir(place) == ["r.nc"]
    measured(f"processes and those that worked: {found}")
    assert all(worked == 1 for _, worked in found)


def test_of_processes_that_write_one_file_without_a_folder_of_their_own_one_wins(nursery, tmp_path):
    commands = [["modes", "dissertation-2", "--count", "2", "-o", "m.json"]] * 6
    ended = nursery.run_all(commands, folder=tmp_path, seconds=300.0)
    assert sorted(one.status for one in ended) == [0, 2, 2, 2, 2, 2], ended
    assert os.listdir(tmp_path) == ["m.json"]


@pytest.fixture
def full(tmp_path):
    """A disk of 4 MB; skips where none can be mounted."""
    place = tmp_path / "disk"
    place.mkdir()
    if os.system(f"mount -t tmpfs -o size=4m none {place} 2>/dev/null") != 0:
        pytest.skip("no disk can be mounted here: needs the rights of an administrator")
    yield place
    os.system(f"umount {place}")


def test_a_disk_that_is_full_at_the_end_keeps_what_is_finished_and_the_command_goes_on(
    full, tmp_path, nursery
):
    """The records fit, the result does not; once there is room, the same command ends with the same bytes."""
    size = 3_100_000
    (full / "other").write_bytes(bytes(size))
    arguments = [*RUN, "--resume", "-o", "r.nc"]
    first = nursery.run(*arguments, folder=full)
    assert first.status in (2, 3), first
    assert "No space left on device" in first.line or "are free" in first.line, first.line
    (full / "other").unlink()
    assert nursery.run(*arguments, folder=full).status == 0
    assert nursery.run(*RUN, "-o", "alone.nc", folder=tmp_path).status == 0
    assert (full / "r.nc").read_bytes() == (tmp_path / "alone.nc").read_bytes()


@pytest.mark.parametrize("command", [["study", "dissertation-3"], RUN, ["modes", "elevator"]])
def test_a_place_that_cannot_be_written_is_refused_before_the_work(command, nursery, tmp_path):
    """Nothing can be made in the folder of processes, whoever asks."""
    if not Path("/proc/self").exists():
        pytest.skip("needs a folder in which nobody can write")
    name = "out.nc" if command == RUN else "out.json" if command[0] == "modes" else "out"
    ended = nursery.run(*command, "-o", f"/proc/self/{name}", folder=tmp_path)
    assert (ended.status, ended.output) == (2, ""), ended
    assert "cannot be written" in ended.line or "is not writable" in ended.line, ended.line
    assert ended.errors.count("\n") == 1, ended.errors


def test_without_a_home_and_with_nowhere_to_keep_kernels_a_command_works(tmp_path):
    environment = {"HOME": "/proc/none", "XDG_CACHE_HOME": "/proc/none", "TMPDIR": "/proc/none"}
    done = run("check", "dissertation-3", "--json", env=environment)
    assert (done.returncode, done.stderr) == (0, "")
    shutil.rmtree(tmp_path / "none", ignore_errors=True)
