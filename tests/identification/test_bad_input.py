"""Whatever is wrong with a log: the status of the contract, and one line on standard error."""

import struct
import zlib
from dataclasses import replace

import numpy as np
import pytest
from reproduction.bench import BENCH_TESTS, bench_rig

from cabledrive.identification.logs.messages import unpacked_mcap
from cabledrive.identification.logs.reading import read_log
from cabledrive.identification.one_log import load_options
from cabledrive.parameters import InputRefused
from cabledrive.rig.experiment import load_excitation
from cabledrive.rig.virtual_rig import run_rig
from cabledrive.studies.study.goals import load_goals
from command import answer, call, object_of, refusal, run, the_line

ROWS, INTERVAL = 12_000, 1e-3
TIME = INTERVAL * np.arange(ROWS)


def rig_log(command, limit=None):
    log = run_rig(replace(bench_rig(BENCH_TESTS[1]), torque_limit=limit), command, np.random.default_rng(0))
    return log.channel("torque"), log.channel("angle")


def sines(amplitude=0.1, bias=0.0):
    return bias + sum(amplitude * np.sin(2 * np.pi * f * TIME + f) for f in (1.0, 3.0, 5.0))


@pytest.fixture(scope="module")
def sound():
    return rig_log(sines())


def text(torque, angle, head="time [s],torque [N m],angle [rad]", rows=slice(None), time=TIME):
    table = np.column_stack([time, torque, angle])[rows]
    return "\n".join([head, *(",".join(f"{x:.9g}" for x in row) for row in table)]) + "\n"


def identified(path, content):
    """What `identify --json` does with a log of this content."""
    path.write_text(content)
    return call("identify", path, "--json")


@pytest.mark.parametrize("still", ["torque", "angle"])
def test_constant_signals_are_refused(tmp_path, sound, still):
    moving = np.array([still != "torque", still != "angle"])
    torque, angle = moving[:, None] * np.array(sound)
    (tmp_path / "t.csv").write_text(text(torque, angle))
    assert f"{still} is constant" in refusal("identify", tmp_path / "t.csv")


def test_a_torque_that_saturates_nearly_always_is_refused(tmp_path):
    torque, angle = rig_log(sines(0.3), limit=0.35)
    (tmp_path / "s.csv").write_text(text(np.clip(torque, -0.35, 0.35), angle))
    assert "the torque saturates" in refusal("identify", tmp_path / "s.csv")


def test_motion_in_one_direction_cannot_part_coulomb_friction_and_offset(tmp_path):
    done = identified(tmp_path / "one.csv", text(*rig_log(sines(0.02, bias=0.15))))
    found = object_of(done.stdout)["parameters"]
    assert done.exit_code == 3
    assert "coulomb friction, offset torque are not identifiable separately" in the_line(done.stderr)
    assert found["coulomb_friction"]["value"] is None
    assert found["inertia"]["value"] == pytest.approx(0.001742, rel=0.05)


@pytest.mark.parametrize("kind", ["swapped", "reversed"])
def test_a_negative_inertia_is_a_finding_with_status_3(tmp_path, sound, kind):
    torque, angle = sound
    done = identified(tmp_path / "n.csv", text(angle, torque) if kind == "swapped" else text(-torque, angle))
    assert done.exit_code == 3, done.stderr
    assert "are torque and angle swapped" in the_line(done.stderr)
    found = object_of(done.stdout)
    assert found["findings"] or not found["identifiable"]


def packed_matlab(path, size):
    """A MATLAB 5 file with one packed column of zeros that are stored in a byte each."""
    matrix = struct.pack("<IIII", 6, 8, 6, 0) + struct.pack("<IIii", 5, 8, size, 1)
    matrix += struct.pack("<HH4s", 1, 1, b"x") + struct.pack("<II", 2, size)
    engine, piece = zlib.compressobj(9), bytes(1 << 20)
    packed = [engine.compress(struct.pack("<II", 14, len(matrix) + size) + matrix)]
    for _ in range(size >> 20):
        packed.append(engine.compress(piece))
    body = b"".join(packed) + engine.flush()
    head = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<H", 0x0100) + b"IM"
    path.write_bytes(head + struct.pack("<II", 15, len(body)) + body)


def test_a_matlab_file_that_unpacks_to_more_than_memory_should_hold_is_refused(
    tmp_path, monkeypatch, measured
):
    """192 MiB from a fifth of a megabyte, where 64 are read, which take twice that while they are."""
    import resource

    monkeypatch.setattr("cabledrive.identification.logs.hierarchical.LARGEST_IN_MEMORY", 64 << 20)
    packed_matlab(tmp_path / "b.mat", 192 << 20)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(InputRefused, match="unpacks to more than"):
        read_log(tmp_path / "b.mat")
    taken = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before  # kB
    measured(f"refused in {taken / 1000:.0f} MB more than before")
    assert taken < 50_000, taken
    packed_matlab(tmp_path / "b.mat", 16 << 20)
    with pytest.raises(InputRefused, match="no column head names a channel"):
        read_log(tmp_path / "b.mat")


def test_an_hdf5_log_too_long_for_memory_is_refused_by_its_shape_and_large_chunks_by_theirs(tmp_path):
    import h5py

    for name, shape, chunk, words in (
        ("long.h5", 4_000_000_000, 1_000_000, "numbers, which are not held in memory"),
        ("chunk.h5", 100_000_000, 100_000_000, "has chunks of 763 MiB"),
    ):
        stored = {"shape": (shape,), "chunks": (chunk,), "dtype": "f8", "compression": "gzip"}
        with h5py.File(tmp_path / name, "w") as file:
            for channel, unit in (("time", "s"), ("torque", "N m"), ("angle", "rad")):
                file.create_dataset(channel, **stored).attrs["units"] = unit
        with pytest.raises(InputRefused, match=words):
            read_log(tmp_path / name)


def test_hdf5_does_not_read_numbers_from_other_files(tmp_path):
    """External storage takes any file for numbers, a virtual dataset may lead through many."""
    import h5py

    (tmp_path / "secret").write_bytes(bytes(8 * 500))
    with h5py.File(tmp_path / "external.h5", "w") as file:
        file["time"], file["angle"] = TIME[:500], TIME[:500]
        file.create_dataset("torque", (500,), "f8", external=[(str(tmp_path / "secret"), 0, 4000)])
    with h5py.File(tmp_path / "virtual.h5", "w") as file:
        file["time"], file["angle"] = TIME[:500], TIME[:500]
        layout = h5py.VirtualLayout((500,), "f8")
        layout[:] = h5py.VirtualSource(tmp_path / "external.h5", "time", (500,))
        file.create_virtual_dataset("torque", layout)
    for name in ("external.h5", "virtual.h5"):
        with pytest.raises(InputRefused, match='"torque" lies in other files'):
            read_log(tmp_path / name)


def test_an_mcap_bomb_is_refused_by_the_heads_of_its_chunks(tmp_path):
    start = struct.pack("<QQQII", 0, 1, 5 << 30, 0, 4) + b"zstd" + struct.pack("<Q", 4) + b"abcd"
    content = b"\x89MCAP0\r\n" + struct.pack("<BQ", 6, len(start)) + start
    (tmp_path / "b.mcap").write_bytes(content)
    assert unpacked_mcap(tmp_path / "b.mcap") == 5 << 30
    with pytest.raises(InputRefused, match=r"more than 1 GiB|extra"):
        read_log(tmp_path / "b.mcap")


def test_a_corrupt_video_is_status_2_in_one_line(tmp_path):
    """In a process of its own: the decoder must not speak on standard error either."""
    pytest.importorskip("cv2", reason="needs the extra camera")
    (tmp_path / "corrupt.mp4").write_bytes(b"no video at all" * 50)
    done = run(
        "camera", tmp_path / "corrupt.mp4", "--frame-rate", "480", "--scale", "1 mm", "--json", "-o", "x.csv"
    )
    assert (done.returncode, done.stdout) == (2, ""), done.stderr
    assert "is no video" in the_line(done.stderr)


# --- The configuration of `identify`: each value is of its kind, or refused in one line with its remedy
READERS = [load_options, load_excitation, load_goals]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('slope = "steep"', 'identify.slope = "steep" is not a quantity'),
        ("slope = -1", "identify.slope = -1 s/rad must be above 0"),
        ('bandwidth = "20 rad/s"', "not Hz"),
        ("bandwidth = true", "identify.bandwidth = true is no quantity"),
        ('check = "no"', 'identify.check = "no" is neither true nor false'),
        ("model = 3", "identify.model = 3 is no text"),
        ('model = "rigid"', 'did you mean "rigid-axis"'),
        ('filter = "none"', 'identify.filter = "none" is unknown'),
        ("bandwith = 1", 'did you mean "bandwidth"'),
        ("slope = 1" + 400 * "0", "is no quantity"),
        ("[log]\ncounts_per_revolution = 0", "must be a whole number of at least 1"),
        ("[log]\ncolumns = 3", "is no table"),
        ('[log]\ncolumns.torque = {column = "tau", scale = [1]}', "is no quantity"),
    ],
)
def test_a_value_of_another_kind_is_refused_with_its_key(line, words, tmp_path):
    path = tmp_path / "identify.toml"
    path.write_text(f"[identify]\n{line}\n")
    with pytest.raises(InputRefused) as refusal:
        load_options(path)
    assert words in str(refusal.value)
    assert str(refusal.value).startswith("identify.toml: ")


@pytest.mark.parametrize("reader", READERS)
def test_a_small_file_that_cannot_be_read_is_refused_in_words(reader, tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "binary").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "deep").write_text("a = " + 5000 * "[")
    (tmp_path / "broken").write_text("a = = 3")
    for name, words in (
        ("absent", "absent: is not there: check the path"),
        ("folder", "folder: is a folder"),
        ("binary/inside", "inside: cannot be read (Not a directory)"),
        ("binary", "binary: not text"),
        ("deep", "deep: not TOML that can be read"),
        ("broken", "broken: not TOML"),
        ("nul\0", "write TOML"),
        ("n" * 300, "cannot be read (File name too long)"),
    ):
        with pytest.raises(InputRefused) as refusal:
            reader(tmp_path / name)
        assert words in str(refusal.value), name
        assert "Errno" not in str(refusal.value)


@pytest.mark.parametrize(("factor", "step"), [(1e3, "1 s"), (1e6, "1000 s")])
def test_a_time_in_another_unit_is_refused_and_the_named_unit_is_taken(tmp_path, sound, factor, step):
    rows = np.column_stack([factor * TIME, *sound])
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header="time,torque,angle", comments="")
    said = refusal("identify", tmp_path / "log.csv")
    assert f"median step {step} is of no servo log" in said
    assert '--column "time=time:ms"' in said
    unit = {1e3: "ms", 1e6: "us"}[factor]
    found = answer("identify", tmp_path / "log.csv", "--column", f"time=time:{unit}")
    assert found["data"][0]["interval"] == pytest.approx(TIME[1])


def test_times_of_day_without_a_date_are_refused_with_what_to_write(tmp_path):
    rows = "".join(f"12:00:{k // 100:02d}.{k % 100:02d}0,0.1,{k}\n" for k in range(300))
    (tmp_path / "log.csv").write_text(f"time,torque [N m],angle [rad]\n{rows}")
    assert "ISO 8601 with a date" in refusal("identify", tmp_path / "log.csv")


def test_no_angle_is_proposed_as_a_torque(tmp_path):
    rows = "".join(f"{k},{k % 7},{k}\n" for k in range(300))
    (tmp_path / "log.csv").write_text(f"stamp,effort,angle actual\n{rows}")
    said = refusal("identify", tmp_path / "log.csv")
    assert "torque=COLUMN:N m" in said
    assert "torque=angle" not in said
