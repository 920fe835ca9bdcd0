"""A log of any format is the same log; what is wrong with it is repaired and said, or refused in one line."""

import json

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet
from reproduction.bench import BENCH_TESTS, bench_command, bench_rig
from scipy import io

from cabledrive.identification.axis.answer import IdentifyOptions
from cabledrive.identification.logs.log import Column, ColumnMap, with_choices
from cabledrive.identification.logs.reading import open_log, read_log
from cabledrive.identification.logs.time_check import saturated
from cabledrive.identification.one_log import identify, identify_long_log, load_options
from cabledrive.parameters import InputRefused
from cabledrive.rig.virtual_rig import run_rig
from oracles.axis_catalogue import TRUTHS, made

N, DT = 2000, 1e-3
TIME = DT * np.arange(N)
TORQUE = 0.2 * np.sin(2 * np.pi * 3 * TIME + 0.3)
QUANTUM = 2 * np.pi / 2600
ANGLE = QUANTUM * np.floor(0.5 * np.sin(2 * np.pi * 3 * TIME) / QUANTUM)


def text(
    head="time [s],torque [N m],angle [rad]", delimiter=",", columns=(TIME, TORQUE, ANGLE), rows=slice(None)
):
    lines = [delimiter.join(repr(float(x)) for x in row) for row in np.column_stack(columns)[rows]]
    return "\n".join([head, *lines]) + "\n"


def is_the_log(log):
    np.testing.assert_allclose(log.channel("torque"), TORQUE, atol=1e-12)
    np.testing.assert_allclose(log.channel("angle"), ANGLE, atol=1e-12)
    assert log.interval == pytest.approx(DT, rel=1e-9)


def written(tmp_path, content, name="log.csv"):
    path = tmp_path / name
    path.write_text(content) if isinstance(content, str) else path.write_bytes(content)
    return path


def test_matlab_5_is_the_same_log_by_a_map(tmp_path):
    io.savemat(
        tmp_path / "log.mat", {"rec": {"t": TIME, "both": np.vstack([TORQUE, ANGLE])}, "gain": 2.0, "n": "x"}
    )
    choices = ["time=rec.t", "torque=rec.both[0]:N m*gain", "angle=rec.both[1]:rad"]
    log = read_log(tmp_path / "log.mat", with_choices(ColumnMap(), choices))
    np.testing.assert_allclose(log.channel("torque"), 2 * TORQUE)
    np.testing.assert_allclose(log.channel("angle"), ANGLE)


CHANNELS = (("time", TIME, "s"), ("torque", TORQUE, "N m"), ("angle", ANGLE, "rad"))


def test_matlab_7_3_and_netcdf_of_both_kinds_are_the_same_log(tmp_path):
    import h5py

    for name, head in (("log.mat", b"MATLAB 7.3 MAT-file".ljust(512)), ("new.nc", b"")):
        with h5py.File(tmp_path / name, "w", userblock_size=len(head)) as file:
            for channel, values, unit in CHANNELS:
                data = file.create_dataset(channel, data=values[None] if head else values)
                data.attrs["units"] = unit
        if head:
            with (tmp_path / name).open("r+b") as file:
                file.write(head)
    with io.netcdf_file(str(tmp_path / "classic.nc"), "w") as file:
        file.createDimension("time", N)
        for name, values, unit in CHANNELS:
            variable = file.createVariable(name, "d", ("time",))
            variable[:] = values
            variable.units = unit
    for path in tmp_path.iterdir():
        is_the_log(read_log(path))


def test_the_map_is_read_from_toml(tmp_path):
    content = '[log]\nsample_rate = "1 kHz"\ncounts_per_revolution = 2600\nstart = "0.5 s"\n[log.columns]\n'
    content += 'torque = {column = "a", unit = "N mm"}\nangle = {column = "b", unit = "counts"}\n'
    columns = load_options(written(tmp_path, content, "map.toml")).columns
    log = read_log(written(tmp_path, text("a,b", columns=(1e3 * TORQUE, np.rint(ANGLE / QUANTUM)))), columns)
    np.testing.assert_allclose(log.channel("angle"), ANGLE[500:], atol=1e-12)
    np.testing.assert_allclose(log.channel("torque"), TORQUE[500:], atol=1e-12)


def test_a_wrapped_angle_is_unwrapped_and_said(tmp_path):
    angle = QUANTUM * np.floor(8.0 * TIME / QUANTUM)
    wrapped = np.mod(angle, 2 * np.pi)
    log = read_log(written(tmp_path, text(columns=(TIME, TORQUE, wrapped))))
    np.testing.assert_allclose(log.channel("angle"), angle, atol=2 * QUANTUM)
    assert "2 wraps" in log.report.repaired[0]


def test_few_missing_rows_are_filled_and_said(tmp_path):
    rows = np.delete(np.arange(N), [100, 101, 700, 1500])
    log = read_log(written(tmp_path, text(rows=rows)))
    assert len(log) == N
    assert np.abs(log.channel("torque") - TORQUE).max() < 1e-3
    assert "4 missing rows" in log.report.repaired[0]


def test_lost_counts_and_saturation_are_found(tmp_path):
    lost = ANGLE.copy()
    lost[1000:] += 40 * QUANTUM
    clipped = np.clip(TORQUE, -0.15, 0.15)
    report = read_log(written(tmp_path, text(columns=(TIME, clipped, lost)))).report
    assert any("angle jumps at 1 samples" in finding for finding in report.findings), report.findings
    assert any("torque stands at the end" in finding for finding in report.findings), report.findings


@pytest.mark.parametrize("excitation", ["multisine", "chirp", "servo", "servo-periodic"])
def test_a_rounded_torque_is_not_cut_and_one_that_is_cut_at_half_is(excitation, measured):
    """Torques of sound axes, rounded to 5 % of their largest value at random phases, as they are and cut."""
    found = np.zeros(2, dtype=int)
    truth = next(one for one in TRUTHS if one.fault == "sound" and one.excitation == excitation)
    for seed in range(10):
        torque, phase = made(truth, 20_000 + seed, 10.0).torque, np.random.default_rng(seed).uniform()
        most = np.abs(torque).max()
        for k, moved in enumerate((torque, np.clip(torque, -0.5 * most, 0.5 * most))):
            step = 0.05 * most
            found[k] += saturated(step * np.floor(moved / step + phase)).any()
    measured(f"rounded {found[0]} of 10, rounded and cut {found[1]} of 10")
    assert found[0] == 0
    assert found[1] == 10


def test_jitter_is_reported_and_uneven_samples_are_not_resampled_unasked(tmp_path):
    rng = np.random.default_rng(4)
    slight = TIME + rng.uniform(-0.05, 0.05, N) * DT
    assert "jitter" in read_log(written(tmp_path, text(columns=(slight, TORQUE, ANGLE)))).report.findings[0]
    strong = TIME + rng.uniform(-0.45, 0.45, N) * DT
    path = written(tmp_path, text(columns=(strong, 0.2 * np.sin(2 * np.pi * 3 * strong + 0.3), ANGLE)))
    with pytest.raises(InputRefused, match="uneven"):
        read_log(path)
    log = read_log(path, ColumnMap(resample=True))
    shifted = 0.2 * np.sin(2 * np.pi * 3 * log.time + 0.3)
    assert np.abs(log.channel("torque") - shifted)[:-1].max() < 1e-4
    assert "as asked" in log.report.repaired[-1]


BAD = {
    "empty": ("", "empty"),
    "only a head": ("time [s],torque [N m]\n", "no row of numbers"),
    "one column": ("torque [N m]\n1.0\n2.0\n3.0\n", "one column|no row"),
    "text in a number column": (
        text().replace(repr(float(TORQUE[50])), "high", 1),
        'line 52, column "torque" holds "high"',
    ),
    "a short row": (text().replace("\n" + repr(float(TIME[70])) + ",", "\n", 1), "line 72 has 2 cells"),
    "mixed units": (text("time [s],torque [rad],angle [N m]"), "torque"),
    "no time": (text("a [s],torque [N m],angle [rad]"), "no column"),
    "no channel": (text("a,b,c"), "no column head names a channel"),
    "time backwards": (text(rows=np.r_[0:500, 400:N]), "backwards at row 501"),
    "a long gap": (text(rows=np.r_[0:500, 600:N]), "100 of 2000 rows are missing"),
    "a tenth dropped": (text(rows=np.arange(N)[np.arange(N) % 10 != 3]), "rows are missing"),
    "binary": (b"\x00\x01\x02" * 50, "not text"),
    "two of a kind": (text("time [s],torque [N m],torque [N mm]"), "two columns|both torque"),
    "infinite": (text().replace(repr(float(TORQUE[50])), "inf", 1), "infinite"),
    "huge": (text(columns=(TIME, 1e300 * TORQUE, ANGLE)), "torque reaches .* no size of a machine"),
    "tiny": (text(columns=(TIME, 1e-300 * TORQUE, ANGLE)), "torque reaches .* no size of a machine"),
    "eternal": (text(columns=(1e300 * TIME, TORQUE, ANGLE)), "time reaches .* no size of a machine"),
    "one row": (text(rows=slice(1)), "only 1 row of numbers"),
    "dates, then seconds": (
        "time,torque\n2026-01-02T00:00:00.000,1\n2026-01-02T00:00:00.001,2\n0.002,3\n",
        'line 4, column "time" holds "0.002": write a time as in the first row',
    ),
    "days": (text().replace("\n", "\n2.1.2026 "), 'no row of numbers up to line .*, "2.1.2026'),
    "a quote that is not closed": (
        text().replace("\n" + repr(float(TIME[39])) + ",", "\n" + repr(float(TIME[39])) + ',"', 1),
        "line 41",
    ),
    "a comma where points are": (text("t tau theta", " ", rows=slice(20)) + "0.020 3,5 4.0\n", "line 22"),
    "a line of 20 MB": (b"1," * 10_000_000, "is longer than 131072 bytes"),
    "a later line of 20 MB": (text().encode() + b"7" * 20_000_000, "is longer than 131072 bytes"),
    "UTF-16 that ends within a character": (text().encode("utf-16")[:-1], "damaged"),
    "heads in other words": (text("Zeit,Moment,Winkel"), '--column "torque=Moment:N m"'),
}


@pytest.mark.parametrize("content, words", BAD.values(), ids=BAD.keys())
def test_a_bad_log_is_refused_in_one_line(tmp_path, content, words):
    with pytest.raises(InputRefused, match=words) as refusal:
        read_log(written(tmp_path, content))
    assert "\n" not in str(refusal.value)


def test_a_folder_is_not_called_a_missing_file(tmp_path):
    (tmp_path / "log.csv").mkdir()
    with pytest.raises(InputRefused, match=r"log\.csv: is a folder: give the path of a log"):
        read_log(tmp_path / "log.csv")
    with pytest.raises(InputRefused, match=r"other\.csv: no such file"):
        read_log(tmp_path / "other.csv")


@pytest.mark.parametrize("name", ["log.parquet", "log.mat", "log.nc", "log.mcap"])
def test_a_corrupt_file_is_refused_in_one_line(tmp_path, name):
    head = {
        "log.parquet": b"PAR1",
        "log.mat": b"MATLAB 5.0",
        "log.nc": b"\x89HDF\r\n\x1a\n",
        "log.mcap": b"\x89MCAP0\r\n",
    }
    with pytest.raises(InputRefused, match=name):
        read_log(written(tmp_path, head[name] + bytes(range(200)) * 9, name))


def test_a_matlab_file_of_objects_only_is_refused(tmp_path):
    io.savemat(tmp_path / "log.mat", {"cell": np.array(["a", "b"], dtype=object), "word": "x"})
    with pytest.raises(InputRefused, match="no column of numbers"):
        read_log(tmp_path / "log.mat", ColumnMap(sample_rate=1.0))


def test_a_mistyped_column_is_named_with_the_nearest(tmp_path):
    columns = ColumnMap(columns={"torque": Column(column="torqe")})
    with pytest.raises(InputRefused, match='did you mean "torque"'):
        open_log(written(tmp_path, text()), columns)


STAMPS = [f"2026-01-02T03:04:{5 + k // 1000:02d}.{k % 1000:03d}" for k in range(N)]


def rows_of(times, delimiter=",", columns=(TORQUE, ANGLE), missing="nan"):
    cells = np.column_stack(columns)
    rows = (delimiter.join([t, *(repr(float(x)) for x in row)]) for t, row in zip(times, cells, strict=True))
    return "\n".join(rows).replace("nan", missing) + "\n"


SECONDS = [repr(float(t)) for t in TIME]
TEKTRONIX = """Model,MSO44,,
Firmware Version,2.0.3,,
Waveform Type,ANALOG,,
Horizontal Units,s,,
Sample Interval,1.0E-3,,
Record Length,2000,,
Vertical Units,V,V,
,,,
Label,torque,angle,
TIME,torque [N m],angle [rad],
"""
TWINCAT = """Name;Scope Project;;
File;C:\\scope.svdx;;
Starttime of export;133000000000000000;03.01.2026;04:05:06

Name;Axis.torque;Axis.angle
SymbolComment;;
Data-Type;REAL64;REAL64
SampleTime[ms];1;1
VariableSize;8;8
SymbolName;MAIN.torque;MAIN.angle
Offset;0;0
ScaleFactor;1;1
Unit;N m;rad

"""


@pytest.mark.parametrize(
    "content",
    [
        text(),
        "# made by a logger\n" + text(),
        text("time [ms];torque [N mm];angle [deg]", ";", (1e3 * TIME, 1e3 * TORQUE, np.degrees(ANGLE))),
        text("time [s];torque [Nm];angle [rad]", ";").replace(".", ","),
        text("time\ttorque\tangle\ns\tN m\trad", "\t"),
        text("t tau theta", " "),
        text("\ufefftime (s),torque (N m),angle (turn)", columns=(TIME, TORQUE, ANGLE / (2 * np.pi))),
        text("time (s)\ttorque (N·m)\tangle (°)", "\t", (TIME, TORQUE, np.degrees(ANGLE))).encode("cp1252"),
        text("time(µs) torque angle", " ", (1e6 * TIME, TORQUE, ANGLE)).encode("cp1252"),
        text("time [s];torque [Nm];angle [rad]", ";").replace(".", ",").encode("utf-16"),
        "#time,torque,angle\n" + rows_of(SECONDS),
        "# made by a logger\n# time [s], torque [N m], angle [rad]\n" + rows_of(SECONDS),
        "# time torque angle\n" + rows_of(SECONDS, " "),
        TEKTRONIX + rows_of(SECONDS).replace("\n", ",\n"),
        "time,torque,angle\n" + rows_of(STAMPS),
        "time;torque;angle\n" + rows_of([f"{stamp}Z" for stamp in STAMPS], ";").replace("T", " "),
        "time,torque,angle\n" + rows_of([f"{stamp}+01:00" for stamp in STAMPS]),
        "time,torque,angle\n+" + rows_of(SECONDS).replace(",", " , "),
        "time,torque,angle\n#\f\n" + rows_of(SECONDS).replace("\n", "\n# \u2028 \f \x1c \x85\n", 1),
        "# \f \u2028 \u2029 \v \x1c \x1d\ntime,torque,angle\n" + rows_of(SECONDS),
        ("time,torque,angle\n" + rows_of(SECONDS)).replace("\n", "\r\n"),
        ("time,torque,angle\n" + rows_of(SECONDS)).replace("\n", "\r"),
    ],
)
def test_every_way_to_write_a_log_gives_all_its_rows(tmp_path, content):
    log = read_log(written(tmp_path, content if isinstance(content, bytes) else content.encode()))
    assert log.report.rows == N, log.report.rows
    is_the_log(log)


def test_a_twincat_export_with_a_decimal_comma_is_the_same_log(tmp_path):
    rows = rows_of([repr(float(1e3 * t)) for t in TIME], ";").replace(".", ",")
    path = written(tmp_path, TWINCAT + rows + "EOF\n")
    log = read_log(path, with_choices(ColumnMap(), ["torque=Axis.torque", "angle=Axis.angle"]))
    is_the_log(log)
    assert log.report.rows == N


def test_lines_above_the_head_are_skipped_as_asked(tmp_path):
    """Three lines that look like a table with other heads."""
    content = "time,torque,angle\n0,1,2\n1,2,3\n" + text()
    log = read_log(written(tmp_path, content), with_choices(ColumnMap(), [], skip_rows=3))
    is_the_log(log)
    with pytest.raises(InputRefused, match="line 4"):
        read_log(written(tmp_path, content))


@pytest.mark.parametrize("missing", ["---", "", "n/a", "-"])
def test_words_for_a_missing_value_are_missing_values(tmp_path, missing):
    torque = TORQUE.copy()
    torque[[0, 5, 900]] = np.nan
    content = "time [s],torque [N m],angle [rad]\n" + rows_of(
        SECONDS, columns=(torque, ANGLE), missing=missing
    )
    log = read_log(written(tmp_path, content))
    assert "3 missing values of torque" in log.report.repaired[0]


def ros_messages(rate):
    """Time [ns] of the log, time of the stamp [ns], torque, angle of one topic."""
    times = np.arange(0.0, 1.0, 1.0 / rate)
    stamps = np.rint(1e9 * times).astype(np.int64) + 1_700_000_000_000_000_000
    delay = np.random.default_rng(1).integers(0, 300_000, times.size)
    return stamps + delay, stamps, 0.2 * np.sin(2 * np.pi * 3 * times + 0.3), np.sin(2 * np.pi * 3 * times)


def test_mcap_is_read_by_the_stamp_of_its_messages_and_two_topics_on_the_times_of_one(tmp_path):
    writing = pytest.importorskip("mcap.writer", reason="needs the extra mcap")
    with (tmp_path / "log.mcap").open("wb") as stream:
        writer = writing.Writer(stream)
        writer.start()
        schema = writer.register_schema(name="s", encoding="jsonschema", data=b"{}")
        for topic, name, rate, column in (("/axis", "angle", 1000, 3), ("/drive", "torque", 400, 2)):
            channel = writer.register_channel(schema_id=schema, topic=topic, message_encoding="json")
            found = ros_messages(rate)
            for k, (when, stamp) in enumerate(zip(found[0], found[1], strict=True)):
                head = {"stamp": {"sec": int(stamp) // 10**9, "nanosec": int(stamp) % 10**9}}
                data = json.dumps({"header": head, name: float(found[column][k])}).encode()
                writer.add_message(channel, log_time=int(when), publish_time=int(when), data=data)
        writer.finish()
    choices = ["time=axis.header.stamp", "angle=axis.angle", "torque=drive.torque:N m"]
    with pytest.raises(InputRefused, match="say --resample"):
        read_log(tmp_path / "log.mcap", with_choices(ColumnMap(), choices))
    log = read_log(tmp_path / "log.mcap", with_choices(ColumnMap(), choices, resample=True))
    assert log.interval == pytest.approx(1e-3, rel=1e-6)
    error = np.abs(log.channel("torque") - 0.2 * np.sin(2 * np.pi * 3 * (log.time - log.time[0]) + 0.3)).max()
    assert error < 3e-4, error  # of straight lines at 400 Hz: (2 pi 3 / 400)^2 / 8 of 0.2
    np.testing.assert_allclose(
        log.channel("angle"), np.sin(2 * np.pi * 3 * (log.time - log.time[0])), atol=1e-9
    )


def test_a_ros_2_bag_is_read_by_its_stamps(tmp_path):
    """Written by rosbags, without the type definitions that bags before ROS 2 Iron lack."""
    rosbag2 = pytest.importorskip("rosbags.rosbag2", reason="needs the extra ros2")
    from rosbags.typesys import Stores, get_typestore

    types = get_typestore(Stores.ROS2_HUMBLE)
    state, header, time = (
        types.types[name]
        for name in ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    )
    with rosbag2.Writer(tmp_path / "bag", version=8) as bag:
        topic = bag.add_connection("/joint_states", state.__msgtype__, typestore=types)
        for when, stamp, torque, angle in zip(*ros_messages(1000), strict=True):
            message = state(
                header=header(stamp=time(sec=int(stamp // 10**9), nanosec=int(stamp % 10**9)), frame_id=""),
                name=["axis"],
                position=np.array([angle]),
                velocity=np.array([]),
                effort=np.array([torque]),
            )
            bag.write(topic, int(when), types.serialize_cdr(message, state.__msgtype__))
    path = next((tmp_path / "bag").glob("*.db3"))
    choices = ["time=joint_states.header.stamp", "angle=joint_states.position[0]:rad"]
    log = read_log(path, with_choices(ColumnMap(), [*choices, "torque=joint_states.effort[0]:N m"]))
    assert (len(log), log.interval) == (1000, pytest.approx(1e-3, rel=1e-6))
    np.testing.assert_allclose(log.channel("torque"), ros_messages(1000)[2], atol=1e-12)
    (tmp_path / "cut.db3").write_bytes(path.read_bytes()[:9000])
    with pytest.raises(InputRefused, match="damaged or unreadable"):
        read_log(tmp_path / "cut.db3")


# --- A log read block by block gives what it gives at once
TEST = BENCH_TESTS[1]


@pytest.fixture
def path(tmp_path):
    rng = np.random.default_rng(5)
    log = run_rig(bench_rig(TEST), bench_command(TEST, rng), rng)
    torque = np.append(np.zeros(3), log.channel("torque")[:-3])  # late by three samples
    torque[52_000] = 80.0
    columns = {
        "time [s]": log.time,
        "torque [N m]": torque,
        "angle [rad]": log.channel("angle"),
    }
    parquet.write_table(pa.table(columns), tmp_path / "log.parquet")
    return tmp_path / "log.parquet"


@pytest.mark.parametrize("kind, torque, end", [("parquet", "found", None), ("csv", "held", 67.0)])
def test_a_log_is_read_in_blocks_with_progress(path, kind, torque, end, monkeypatch):
    """No more is held than a block: the parameters of the whole, a line for every block of a text.

    The instant of the torque is found in the first, a wrong sample replaced in each.

    Apart from filter ends and the bandwidth of the first block: within half a standard error.
    """
    if kind == "csv":
        columns = parquet.read_table(path).to_pydict()
        rows = (",".join(f"{cell:.9g}" for cell in row) for row in zip(*columns.values(), strict=True))
        path = path.with_suffix(".csv")
        path.write_text("\n".join([",".join(columns), *rows]) + "\n")
    options = IdentifyOptions(check=False, torque=torque, columns=ColumnMap(start=end and 3.0, end=end))
    whole = identify(path, options, method="inverse-dynamics")
    monkeypatch.setattr("cabledrive.identification.one_log.MOST_VALUES", 100_000)
    monkeypatch.setattr("cabledrive.identification.one_log.BLOCK_ROWS", 17_000)
    monkeypatch.setattr("cabledrive.identification.logs.reading.BLOCK_ROWS", 5_000)
    monkeypatch.setattr("cabledrive.identification.logs.text.BLOCK_BYTES", 100_000)
    lines = []
    blocks = identify(path, options, progress=lines.append)
    rows, last = (64_000, 67_000) if end else (70_000, 70_000)
    assert blocks.reports[0].rows == pytest.approx(rows, abs=1)
    assert len(lines) == blocks.method["blocks"] > 2
    assert lines[-1].startswith(f"{path.name}: {last} rows")
    assert "outliers" in blocks.codes
    assert blocks.method["torque_shift"] == pytest.approx(5e-4 if torque == "held" else -3e-3, abs=2e-5)
    for name, estimate in whole.parameters.items():
        off = abs(blocks[name] - estimate.value) / estimate.standard_error
        assert off < 0.5, f"{name}: {off:.2f} standard errors"


def test_blocks_in_which_nothing_moves_are_left_out_and_said(path, tmp_path, monkeypatch):
    """The machine rests for two blocks: the parameters stay, the report counts the rows."""
    columns = {name: np.array(values) for name, values in parquet.read_table(path).to_pydict().items()}
    first, step = (values[0] for values in columns.values()), 1e-3
    still = dict(zip(columns, (np.full(34_000, value) for value in first), strict=True))
    still["time [s]"] = columns["time [s]"][-1] + step * np.arange(1, 34_001)
    joined = {name: np.concatenate([columns[name][:68_000], still[name]]) for name in columns}
    joined["time [s]"] = step * np.arange(102_000)
    parquet.write_table(pa.table(joined), tmp_path / "rest.parquet")
    monkeypatch.setattr("cabledrive.identification.one_log.BLOCK_ROWS", 17_000)
    found, whole = identify_long_log(open_log(tmp_path / "rest.parquet")), identify_long_log(open_log(path))
    assert "34000 rows in blocks in which nothing moves" in found.reports[0].findings[-1]
    assert found["inertia"] == pytest.approx(whole["inertia"], rel=1e-3)
