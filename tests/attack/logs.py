"""Damaged logs of every format, seeded: each is read, or refused in one line, within time and memory.

A batch runs in a process of its own, so that a library that crashes or does not return is seen too:
``python tests/attack/logs.py --seed 1 --count 10000`` adds a batch to the ledger and prints its outcomes.
"""

import argparse
import json
import multiprocessing
import resource
import signal
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

if __package__ in (None, ""):
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from attack import ledger

ROWS = 240
PRINTER_LOGS = ("resonances_x.csv", "calibration_data_y.csv", "raw_data_x.csv")
SECONDS, BYTES = 5.0, 2 << 30
TIME = 1e-3 * np.arange(ROWS)
TORQUE, ANGLE = np.sin(40 * TIME), np.cumsum(np.sin(37 * TIME))
TOKENS = (
    *("\f", "\u2028", "\x85", "\x00", '"', "'", "#", "---", "EOF", ",", ";", "\t", "\r", "\n", "\r\n", "\\"),
    *(
        "nan",
        "inf",
        "-inf",
        "1e400",
        "1e-400",
        "0x10",
        "1_000",
        "１",
        "+1",
        "--1",
        "1,5",
        "Name",
        "[N m]",
        "\ufeff",
    ),
    *("2026-01-02T03:04:05Z", "2026-02-30T00:00:00", "9" * 400, "x" * 140_000),
)
INTEGERS = (0, 1, 0x7F, 0xFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0x10000000)


def sound_logs(folder: Path) -> list[Path]:
    """One small log in every format that can be written here."""
    heads, columns = ("time [s]", "torque [N m]", "angle [rad]"), (TIME, TORQUE, ANGLE)
    rows = [",".join(f"{x:.6f}" for x in row) for row in zip(*columns, strict=True)]
    text = "\n".join([",".join(heads), *rows]) + "\n"
    stamps = [f"2026-01-02T03:04:05.{k:03d}," + row.partition(",")[2] for k, row in enumerate(rows)]
    written = {
        "plain.csv": text.encode(),
        "stamps.csv": "\n".join(["# made", ",".join(heads), *stamps]).encode(),
        "comma.csv": text.replace(",", ";").replace(".", ",").encode(),
        "white.txt": text.replace(" [", "[").replace("N m", "Nm").replace(",", " ").encode(),
        "wide.tsv": text.replace(",", "\t").encode("utf-16"),
        "scope.csv": ("Model,X,\nRecord Length,240,\n,,\n" + text).encode("cp1252"),
    }
    lines = [f"{1.5625 * k:.1f}" + 3 * f",{1e3 / (1 + (k - 30) ** 2):.3e}" for k in range(129)]
    moved = [f"{0.625e-3 * k:.6f}" + 2 * f",{9810 + 99 * (-1) ** (k // 9):.6f}" for k in range(1200)]
    heads_of_a_test = ("freq,psd_x,psd_y,psd_xyz", "freq,psd_x,psd_y,psd_xyz,shapers:,zv(59.0)")
    written |= {
        "resonances_x.csv": "\n".join([heads_of_a_test[0], *lines]).encode(),
        "calibration_data_y.csv": "\n".join([heads_of_a_test[1], *(f"{x},,0.5" for x in lines)]).encode(),
        "raw_data_x.csv": "\n".join(["#time,accel_x,accel_y", *moved]).encode(),
    }
    for name, content in written.items():
        (folder / name).write_bytes(content)
    _binary(folder, dict(zip(heads, columns, strict=True)))
    return sorted(folder.iterdir())


def _binary(folder: Path, columns: dict[str, np.ndarray]) -> None:
    import h5py
    import pyarrow as pa
    from pyarrow import parquet
    from scipy import io

    for compression in ("snappy", "zstd"):
        parquet.write_table(pa.table(columns), folder / f"{compression}.parquet", compression=compression)
    plain = {name.partition(" ")[0]: values for name, values in columns.items()}
    io.savemat(folder / "five.mat", plain)
    io.savemat(folder / "packed.mat", {**plain, "rec": {"a": TIME, "gain": 2.0}}, do_compression=True)
    io.savemat(folder / "four.mat", plain, format="4")
    for name, options in (("plain.h5", {}), ("packed.nc", {"chunks": (64,), "compression": "gzip"})):
        with h5py.File(folder / name, "w") as file:
            for channel, values in plain.items():
                file.create_dataset(channel, data=values, **options).attrs["units"] = (
                    "s" if channel == "time" else ""
                )
    with io.netcdf_file(str(folder / "classic.nc"), "w") as file:
        file.createDimension("rows", ROWS)
        for channel, values in plain.items():
            file.createVariable(channel, "d", ("rows",))[:] = values
    _mcap(folder / "json.mcap", plain)
    _bag(folder, plain)


def _mcap(path: Path, columns: dict[str, np.ndarray]) -> None:
    try:
        from mcap.writer import Writer
    except ImportError:
        return
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema(name="s", encoding="jsonschema", data=b"{}")
        topic = writer.register_channel(schema_id=schema, topic="/a", message_encoding="json")
        for row in zip(*columns.values(), strict=True):
            data = json.dumps(dict(zip(columns, row, strict=True))).encode()
            writer.add_message(topic, log_time=round(1e9 * row[0]), publish_time=0, data=data)
        writer.finish()


def _bag(folder: Path, columns: dict[str, np.ndarray]) -> None:
    try:
        from rosbags.rosbag2 import Writer
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        return
    types = get_typestore(Stores.ROS2_HUMBLE)
    kind = types.types["geometry_msgs/msg/Vector3"]
    with tempfile.TemporaryDirectory() as place:
        with Writer(Path(place) / "bag", version=8) as bag:
            topic = bag.add_connection("/a", kind.__msgtype__, typestore=types)
            for t, x, y in zip(*columns.values(), strict=True):
                data = types.serialize_cdr(kind(x=x, y=y, z=t), kind.__msgtype__)
                bag.write(topic, round(1e9 * t), data)
        next((Path(place) / "bag").glob("*.db3")).rename(folder / "bag.db3")


def damaged(content: bytes, text: bool, rng: np.random.Generator) -> bytes:
    """One to three faults: flipped bits, zeroed, random or repeated blocks, cuts, odd integers, odd words."""
    data = bytearray(content)
    for _ in range(rng.integers(1, 4)):
        size = len(data)
        if size < 2:
            break
        longest = min(size, int(rng.choice([8, 64, 600])))
        start, length = int(rng.integers(size)), int(rng.integers(1, 1 + longest))
        kind = rng.integers(8)
        if text and kind in (3, 7):
            token = str(rng.choice(TOKENS))
            utf16 = data[:2] in (b"\xff\xfe", b"\xfe\xff")
            data[start:start] = token.encode("utf-16-le" if utf16 else "utf-8")
        elif kind == 0:
            for place in rng.integers(size, size=rng.integers(1, 9)):
                data[place] ^= 1 << rng.integers(8)
        elif kind == 1:
            data[start : start + length] = bytes(min(length, size - start))
        elif kind == 2:
            data[start : start + length] = rng.bytes(min(length, size - start))
        elif kind == 3:
            value = int(rng.choice(INTEGERS)).to_bytes(4, "little")
            data[start : start + 4] = value * int(rng.integers(1, 3))
        elif kind == 4:
            del data[start:]
        elif kind == 5:
            del data[start : start + length]
        elif kind == 6:
            data[start:start] = data[start : start + length]
        else:
            other = int(rng.integers(size))
            data[start : start + length] = data[other : other + length]
    return bytes(data)


def outcome_of(path: Path, of_a_printer: bool = False) -> tuple[str, str]:
    """How reading ends: "read", "refused", or "defect" with what was raised."""
    from cabledrive.identification.logs.column_map import ColumnMap, with_choices
    from cabledrive.identification.logs.reading import read_log
    from cabledrive.identification.printer_spectrum import read_printer_spectrum
    from cabledrive.identification.spectrum_peaks import spectrum_peaks
    from cabledrive.parameters import InputRefused, NotComputed

    maps = {
        ".db3": ["time=a.z", "torque=a.x:N m", "angle=a.y:rad"],
        ".mcap": ["time=a.time", "torque=a.torque", "angle=a.angle"],
    }
    try:
        if of_a_printer:
            spectrum_peaks(read_printer_spectrum(path))
        else:
            read_log(path, with_choices(ColumnMap(), maps.get(path.suffix, [])))
    except (InputRefused, NotComputed) as refusal:
        return ("refused", "") if "\n" not in str(refusal) else ("defect", "two lines")
    except BaseException as defect:
        return "defect", f"{type(defect).__name__}: {defect}"[:200]
    return "read", ""


def _batch(seed: int, numbers: list[int], folder: Path, report: Path) -> None:
    """In a process of its own: one line of JSON for each case, begun before it is read."""
    (folder / "sound").mkdir(exist_ok=True)
    logs = sound_logs(folder / "sound")
    warnings.simplefilter("error")
    with report.open("a") as file:
        for number in numbers:
            rng = np.random.default_rng([seed, number])
            source = logs[number % len(logs)]
            mutant = folder / f"mutant{source.suffix}"
            text = source.suffix in (".csv", ".txt", ".tsv")
            mutant.write_bytes(damaged(source.read_bytes(), text, rng))
            file.write(json.dumps({"number": number, "source": source.name}) + "\n")
            file.flush()
            began = time.process_time()
            signal.alarm(60)
            outcome, what = outcome_of(mutant, source.name in PRINTER_LOGS)
            signal.alarm(0)
            seconds = time.process_time() - began
            if seconds > SECONDS:
                outcome, what = "slow", f"{seconds:.1f} s"
            file.write(json.dumps({"number": number, "outcome": outcome, "what": what}) + "\n")
        file.write(json.dumps({"peak": _peak()}) + "\n")


def _peak() -> int:
    """Largest memory of this process [bytes]; that of `getrusage` begins with the one before it."""
    status = Path("/proc/self/status")
    if status.exists():
        return 1024 * int(status.read_text().split("VmHWM:")[1].split()[0])
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def attack(seed: int, count: int) -> tuple[Counter[str], list[str], int]:
    """Outcomes of a batch, every bad one in words, and the largest memory of its processes [bytes]."""
    outcomes: Counter[str] = Counter()
    bad: list[str] = []
    with tempfile.TemporaryDirectory() as place:
        folder, report = Path(place), Path(place) / "report.jsonl"
        numbers = list(range(count))
        while numbers:
            process = multiprocessing.get_context("spawn").Process(
                target=_batch, args=(seed, numbers, folder, report)
            )
            process.start()
            process.join()
            begun = [entry["number"] for entry in _entries(report) if "source" in entry]
            done = {entry["number"] for entry in _entries(report) if "outcome" in entry}
            if process.exitcode and begun and begun[-1] not in done:
                line = {"number": begun[-1], "outcome": "crash", "what": f"exit status {process.exitcode}"}
                with report.open("a") as file:
                    file.write(json.dumps(line) + "\n")
                done.add(begun[-1])
            elif process.exitcode:
                raise RuntimeError(f"the batch ended with status {process.exitcode}")
            numbers = [number for number in numbers if number not in done]
        entries = list(_entries(report))
        sources = {entry["number"]: entry["source"] for entry in entries if "source" in entry}
        for entry in entries:
            if "outcome" in entry:
                outcomes[entry["outcome"]] += 1
                if entry["outcome"] not in ("read", "refused"):
                    message = f"{sources[entry['number']]}, seed {seed}, number {entry['number']}"
                    bad.append(f"{message}: {entry['outcome']}, {entry['what']}")
        peak = max((entry["peak"] for entry in entries if "peak" in entry), default=0)
    return outcomes, bad, peak


def _entries(report: Path) -> Iterator[dict]:
    return (json.loads(line) for line in report.read_text().splitlines())


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--count", type=int, default=2000)
    given = parser.parse_args()
    outcomes, bad, peak = attack(given.seed, given.count)
    ledger.note("logs", given.seed, outcomes)
    print(*bad, dict(outcomes), f"{peak / 2**20:.0f} MiB", dict(ledger.totals()["logs"]), sep="\n")
