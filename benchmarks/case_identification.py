"""Identification of one axis: a log of 70 s, and one hour at 10 kHz in bounded memory."""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pyarrow as pa
from harness import duration, side_by_side, table
from pyarrow import parquet
from reproduction.bench import BENCH_TESTS, bench_command, bench_rig

from cabledrive.identification.one_log import identify
from cabledrive.identification.planning import sum_of_sines
from cabledrive.reduction.friction_integration import integrate_rigid_axis
from cabledrive.rig.virtual_rig import run_rig

TITLE = "Identification"
RATE, MINUTE, MINUTES = 10_000, 600_000, 60
QUANTUM = 2 * np.pi / 2600
CONFIG = """[log]
sample_rate = "10 kHz"
"""
ALONE = """
import json, resource, sys, time
from cabledrive.identification.one_log import identify, load_options
start = time.process_time()
found = identify(sys.argv[1], load_options(sys.argv[2]))
usage = resource.getrusage(resource.RUSAGE_SELF)
print(json.dumps({"seconds": time.process_time() - start, "gigabytes": usage.ru_maxrss / 2**20,
                  "rows": found.reports[0].rows, "inertia": found["inertia"]}))
"""


def report() -> str:
    test = BENCH_TESTS[1]
    rng = np.random.default_rng(2015)
    log = run_rig(bench_rig(test), bench_command(test, rng), rng)
    name = "identify, 70 s at 1 kHz, checked"
    rows = [(name, duration(side_by_side({name: lambda: identify(log)})[name]), "1 s")]
    with tempfile.TemporaryDirectory() as folder:
        long_log = written(Path(folder))
        one = alone(long_log)
    rows.append((f"identify, {one['rows']:,} samples, Parquet", f"{one['seconds']:.1f} s", "60 s"))
    rows.append(("its largest memory", f"{one['gigabytes']:.2f} GiB", "2 GB"))
    off = 100 * (one["inertia"] / test.inertia - 1)
    note = f"The hour is read in a process of its own; its inertia is {off:+.3f} % off."
    return table(["what", "processor time", "target"], rows) + "\n\n" + note


def written(folder: Path) -> Path:
    """One hour of torque and angle, minute by minute."""
    test = BENCH_TESTS[1]
    rng = np.random.default_rng(2015)
    values = np.array([test.inertia, test.viscous, test.coulomb, test.offset])
    torque = 1.6218 * sum_of_sines(60.0, RATE, test.frequencies, test.amplitudes)
    path, speed, angle = folder / "hour.parquet", 0.0, 0.0
    schema = pa.schema([("torque [N m]", pa.float64()), ("angle [rad]", pa.float64())])
    with parquet.ParquetWriter(path, schema) as writer:
        for _ in range(MINUTES):
            moved, _ = integrate_rigid_axis(values, np.append(torque, torque[0]), 1 / RATE, start=speed)
            rise = np.cumsum(0.5 * (moved[1:] + moved[:-1])) / RATE
            exact = angle + np.concatenate([[0.0], rise[:-1]])
            measured = torque + 0.006 * rng.normal(size=MINUTE)
            columns = [measured, QUANTUM * np.floor(exact / QUANTUM)]
            writer.write_table(pa.Table.from_arrays([pa.array(c) for c in columns], schema=schema))
            speed, angle = float(moved[-1]), angle + float(rise[-1])
    (folder / "log.toml").write_text(CONFIG)
    return path


def alone(path: Path) -> dict:
    done = subprocess.run(
        [sys.executable, "-c", ALONE, str(path), str(path.with_name("log.toml"))],
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(done.stdout)
