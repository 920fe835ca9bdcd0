"""Long runs: on disk as they go, resumed bit for bit whatever ended them, nothing lost on a full disk."""

import errno
import os
import signal
import subprocess
import sys
import tempfile
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from cabledrive.parameters.drive_file import load_drive
from cabledrive.parameters.errors import InputRefused
from cabledrive.simulation import (
    Pluck,
    Recording,
    Sampled,
    Scheme,
    SimulationInterrupted,
    Sine,
    Start,
    keeping,
    netcdf,
    run,
    simulate,
)
from cabledrive.simulation.travel import PlannedMove
from command import python

DRIVE = load_drive("dissertation-2")
DURATION = 0.05
OPTIONS = {
    "torque": Sine(amplitude=0.02, frequency=81.7),
    "start": Start(plucks=(Pluck(height=1e-3),)),
    "scheme": Scheme(segments=12),
    "recording": Recording(rate=5000.0, fields=7, probes=(("lower", 0.3),)),
}
LIFTED = PlannedMove(moves={"car.y": 4.0}, rise=5.0)
SMALL = {"scheme": Scheme(segments=4), "recording": Recording(rate=2000.0)}
RUNS = {
    "loop": (DRIVE, DURATION, OPTIONS),
    "network": (load_drive("printer-idlers"), DURATION, SMALL | {"torque": 0.01}),
    "journey": (load_drive("lift-2-to-1"), DURATION, SMALL | {"travel": LIFTED}),
}
KILLED = """
import os, signal
from cabledrive.simulation import run, keeping
import test_resume as t
run.NODE_STEPS_PER_CHUNK, run.SECONDS_PER_COMMIT = 3000, 0.0
commit, done = keeping.RecordsInFolder.commit, []
def commit_and_die(self, state, number):
    if len(done) == 3:
        self.files[0].write(b"half a record")  # written, but not committed
        self.files[0].flush()
        os.kill(os.getpid(), signal.SIGKILL)
    commit(self, state, number)
    done.append(number)
keeping.RecordsInFolder.commit = commit_and_die
t.simulate(t.DRIVE, t.DURATION, output="run.nc", **t.OPTIONS)
"""


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch):
    """A dozen chunks, each committed."""
    monkeypatch.setattr(run, "NODE_STEPS_PER_CHUNK", 3000)
    monkeypatch.setattr(run, "SECONDS_PER_COMMIT", 0.0)


def at_call(function, number, action):
    """The function, with something else in place of its n-th call."""
    calls = []

    def watched(*arguments):
        calls.append(arguments)
        return action(*arguments) if len(calls) == number else function(*arguments)

    return watched


def interrupt(*arguments):
    raise KeyboardInterrupt


def broken_off(monkeypatch, path, call, kind="loop"):
    """What there is of a run that is interrupted where it writes its n-th chunk."""
    drive, duration, options = RUNS[kind]
    with monkeypatch.context() as patched:
        append = keeping.RecordsInFolder.append
        patched.setattr(keeping.RecordsInFolder, "append", at_call(append, call, interrupt))
        with pytest.raises(SimulationInterrupted, match="go on with the same command and --resume") as caught:
            simulate(drive, duration, output=path, **options)
    return caught.value.result


def disk_full(*arguments, **options):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@cache
def uninterrupted(kind="loop"):
    """The file of the run that nothing ended."""
    drive, duration, options = RUNS[kind]
    with tempfile.TemporaryDirectory() as folder:
        return simulate(drive, duration, output=Path(folder) / "whole.nc", **options).path.read_bytes()


def differing(path, kind="loop"):
    """How many bytes of a file are not those of an uninterrupted run, in words."""
    found, whole = path.read_bytes(), uninterrupted(kind)
    differ = sum(a != b for a, b in zip(found, whole, strict=False)) + abs(len(found) - len(whole))
    return f"{differ} of {len(whole):,} bytes differ"


@pytest.mark.parametrize(
    ("kind", "call"), [*(("loop", call) for call in (1, 2, 6)), ("network", 3), ("journey", 3)]
)
def test_an_interrupted_run_is_resumed_to_the_byte(tmp_path, monkeypatch, kind, call, measured):
    path, (drive, duration, options) = tmp_path / "run.nc", RUNS[kind]
    if kind == "journey":  # of few steps
        monkeypatch.setattr(run, "NODE_STEPS_PER_CHUNK", 300)
    partial = broken_off(monkeypatch, path, call, kind)
    assert partial.time.size == 0 or partial.time[-1] < duration
    assert os.listdir(tmp_path) == ["run.nc.part"]
    if kind == "network":
        with pytest.raises(InputRefused, match="another torque"):
            simulate(drive, duration, output=path, resume=True, **(options | {"torque": 0.02}))
    resumed = simulate(drive, duration, output=path, resume=True, **options)
    measured(f"{kind}, interrupted at record {call}: {differing(path, kind)}")
    assert path.read_bytes() == uninterrupted(kind)
    assert resumed.steps == round(duration / resumed.step)
    assert os.listdir(tmp_path) == ["run.nc"]


def test_a_killed_run_is_resumed_to_the_byte(tmp_path, measured):
    """kill -9 in the middle of a chunk, half a record written behind the last commit."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([os.path.dirname(__file__), *sys.path])}
    died = subprocess.run([sys.executable, "-c", KILLED], cwd=tmp_path, env=environment, capture_output=True)
    assert died.returncode == -signal.SIGKILL, died.stderr.decode()
    path = tmp_path / "run.nc"
    assert not path.exists()
    simulate(DRIVE, DURATION, output=path, resume=True, **OPTIONS)
    measured(f"ended by signal {-died.returncode}: {differing(path)}")
    assert path.read_bytes() == uninterrupted()


RUN = """
import sys, test_resume as t
from dataclasses import replace
damped = replace(t.DRIVE, cable=replace(t.DRIVE.cable, axial_damping=0.02))
whirling = t.Start(plucks=(t.Pluck(height=1e-3), t.Pluck(height=1e-3, plane="v")))
scheme = t.Scheme(segments=12, method=sys.argv[1])
runs = [(t.DRIVE, t.OPTIONS["start"]), (t.DRIVE, whirling), (damped, whirling)]
for drive, start in runs[: 2 if scheme.method == "node-centred" else 3]:
    rows = t.simulate(drive, t.DURATION, **t.OPTIONS | {"scheme": scheme, "start": start}).rows
    sys.stdout.write(rows.tobytes().hex())
"""


@pytest.mark.verify  # compiles everything twice
@pytest.mark.parametrize("name", ["verlet", "node-centred", "energy-conserving"])
def test_who_compiles_and_who_loads_what_was_compiled_compute_the_same(tmp_path, name, measured):
    """Else a run that was killed before its kernels were in the cache would not be resumed to the byte."""
    given = {"paths": [Path(__file__).parent], "XDG_CACHE_HOME": str(tmp_path)}
    compiled, loaded, again = (python(RUN, name, **given) for _ in range(3))
    differ = sum(a != b for other in (loaded, again) for a, b in zip(compiled, other, strict=False))
    measured(
        f"{differ} of {len(compiled):,} hexadecimal digits differ in either of two processes that loaded"
    )
    assert len(compiled) > 10_000
    assert compiled == loaded == again


@pytest.mark.parametrize("method", ["append", "commit"])
def test_a_full_disk_stops_the_run_and_loses_nothing(tmp_path, monkeypatch, method, measured):
    path = tmp_path / "run.nc"
    with monkeypatch.context() as patched:
        original = getattr(keeping.RecordsInFolder, method)
        patched.setattr(keeping.RecordsInFolder, method, at_call(original, 4, disk_full))
        result = simulate(DRIVE, DURATION, output=path, **OPTIONS)
    assert "No space left on device" in result.stopped
    assert "free space and resume" in result.stopped
    assert 0.0 < result.time[-1] < DURATION
    simulate(DRIVE, DURATION, output=path, resume=True, **OPTIONS)
    measured(f"full at {1e3 * result.time[-1]:.1f} ms: {differing(path)}")
    assert path.read_bytes() == uninterrupted()


@pytest.mark.skipif(sys.platform == "win32", reason="needs a limit on the size of files")
@pytest.mark.parametrize("share", [0.0, 0.5, 0.999])
def test_a_disk_that_refuses_while_a_result_is_written_leaves_nothing(tmp_path, share):
    """HDF5 crashes a process in which a write fails: it is told of none, and writes the next file whole."""
    import resource

    result, paths = simulate(DRIVE, DURATION, **OPTIONS), (tmp_path / "run.nc", tmp_path / "run.nc.new")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (int(share * len(uninterrupted())), before[1]))
    try:
        with pytest.raises(OSError, match="File too large"):
            netcdf.write_netcdf(result.content, *paths)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert os.listdir(tmp_path) == []
    netcdf.write_netcdf(result.content, *paths)
    assert paths[0].stat().st_size == pytest.approx(len(uninterrupted()), rel=0.1)


def test_another_run_is_not_resumed_with_this_one_s_records(tmp_path, monkeypatch):
    path = tmp_path / "run.nc"
    broken_off(monkeypatch, path, 3)
    other = replace(DRIVE, cable=replace(DRIVE.cable, pretension=4.0))
    with pytest.raises(InputRefused, match="holds a run with another drive_hash"):
        simulate(other, DURATION, output=path, resume=True, **OPTIONS)
    torque = {**OPTIONS, "torque": Sampled(values=np.zeros(1000), rate=10_000.0)}
    with pytest.raises(InputRefused, match="holds a run with another torque"):
        simulate(DRIVE, DURATION, output=path, resume=True, **torque)
    with pytest.raises(InputRefused, match=r"left by an interrupted run: go on with it \(resume\)"):
        simulate(DRIVE, DURATION, output=path, **OPTIONS)
    simulate(DRIVE, DURATION, output=path, force=True, **OPTIONS)
    assert path.read_bytes() == uninterrupted()


@pytest.fixture
def stopped(tmp_path, monkeypatch):
    """A run that was interrupted at its fourth chunk; returns its output."""
    path = tmp_path / "run.nc"
    broken_off(monkeypatch, path, 4)
    return path


def shorter(content):
    return content[:-9]


BROKEN = [
    *((name, shorter) for name in ("rows.f64", "fields.f64")),
    ("checkpoint", shorter),
    ("checkpoint", lambda content: bytes(len(content) // 2) + content[len(content) // 2 :]),
    ("checkpoint", lambda content: content[:-100] + bytes([content[-100] ^ 4]) + content[-99:]),
    ("checkpoint", lambda content: b"PK not a checkpoint"),
    ("checkpoint", lambda content: b""),
    ("run.json", lambda content: b"[1, 2]"),
    ("run.json", lambda content: b"\xff{"),
    ("run.json", lambda content: b"[" * 100_000),
    ("run.json", lambda content: b""),
]


@pytest.mark.parametrize(("name", "damage"), BROKEN)
def test_a_damaged_part_of_an_interrupted_run_is_refused(stopped, name, damage):
    """Nothing is filled with zeros, no number is believed that was not written whole."""
    part = stopped.with_name("run.nc.part") / name
    part.write_bytes(damage(part.read_bytes()))
    before = {path.name: path.read_bytes() for path in part.parent.iterdir()}
    with pytest.raises(InputRefused, match=r"run\.nc\.part: cannot be resumed .*start anew with force"):
        simulate(DRIVE, DURATION, output=stopped, resume=True, **OPTIONS)
    assert {path.name: path.read_bytes() for path in part.parent.iterdir() if path.name != ".lock"} == before
    assert not stopped.exists()
    simulate(DRIVE, DURATION, output=stopped, force=True, **OPTIONS)
    assert stopped.read_bytes() == uninterrupted()


def test_what_was_written_since_the_last_commit_may_be_lost(stopped):
    """A loss of power takes it back, or leaves zeros: it is cut off and done again."""
    part = stopped.with_name("run.nc.part")
    for name in ("rows.f64", "fields.f64"):
        (part / name).write_bytes((part / name).read_bytes() + bytes(5000))
    simulate(DRIVE, DURATION, output=stopped, resume=True, **OPTIONS)
    assert stopped.read_bytes() == uninterrupted()


def test_files_that_no_run_wrote_are_not_deleted(stopped):
    (stopped.with_name("run.nc.part") / "thesis.txt").write_text("precious")
    with pytest.raises(InputRefused, match=r"holds thesis\.txt, which is no run's"):
        simulate(DRIVE, DURATION, output=stopped, force=True, **OPTIONS)
    assert (stopped.with_name("run.nc.part") / "thesis.txt").read_text() == "precious"


@pytest.mark.parametrize("option", ["resume", "force"])
def test_a_second_process_on_a_run_is_refused(tmp_path, monkeypatch, option):
    """Neither resume nor force takes a run from the process that works on it."""
    path, refusals, append = tmp_path / "run.nc", [], keeping.RecordsInFolder.append

    def second(*arguments):
        with pytest.raises(InputRefused, match="another process works there") as caught:
            simulate(DRIVE, DURATION, output=path, **{option: True}, **OPTIONS)
        refusals.append(str(caught.value))
        return append(*arguments)

    with monkeypatch.context() as patched:
        patched.setattr(keeping.RecordsInFolder, "append", at_call(append, 3, second))
        simulate(DRIVE, DURATION, output=path, **OPTIONS)
    assert len(refusals) == 1
    assert path.read_bytes() == uninterrupted()
    assert os.listdir(tmp_path) == ["run.nc"]
