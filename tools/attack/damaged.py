"""Damaged files of every kind that a command reads, each read by a process of its own.

A case is made from kind, seed and number alone. Each ends with status 0, 2 or 3, with one line where it is
not 0, within a time and a memory; a library that crashes or never returns is seen too.
"""

import io
import json
import os
import random
import resource
import signal
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Callable
from contextlib import redirect_stdout, suppress
from dataclasses import dataclass
from pathlib import Path

from cabledrive.app.failures import status_of
from cabledrive.app.main import main
from cabledrive.campaign.spec import read_spec
from cabledrive.export.source import designed, read_source
from cabledrive.identification.logs.log import ColumnMap, with_choices
from cabledrive.identification.logs.reading import read_log
from cabledrive.identification.printer_spectrum import read_printer_spectrum
from cabledrive.identification.spectrum_peaks import spectrum_peaks
from cabledrive.parameters import load_drive, packaged_drives
from cabledrive.parameters.drive_file import packaged_text
from cabledrive.rig.experiment import check_excitation, load_excitation
from cabledrive.rig.plant_samples import load_disturbances
from cabledrive.studies.planned_motion import read_motion
from cabledrive.studies.study import load_goals
from drive_strategies import FILES
from sound_logs import sound_logs

SECONDS, BYTES = 5.0, 2 << 30
GOALS = b"""error = "0.5 deg"
[motion]
angle = "30 deg"
duration = "0.3 s"
dwell = 0.1
pulses = 2
order = 9
[carriage]
travel = "0.1 m"
hanging_mass = "1 kg"
line_length = "2 m"
[acceptance]
draws = 5
cable_draws = 1
seed = 3
[uncertainty]
inertia = "10 %"
stiffness = 0.2
"""
EXCITATION = b"""kind = "sines"
amplitude = "2 V"
duration = "2 s"
frequencies = ["3 Hz", "7.5 Hz", 11]
"""
SWEEP = b"""drive = "dissertation-3"
[vary]
"pulley.1.inertia" = { from = "20 kg cm^2", to = "26 kg cm^2" }
"cable.pretension" = { values = ["3 N", 4, "500 gf"] }
"motor.joint_stiffness" = { normal = ["130 N m/rad", "5 N m/rad"] }
[design]
kind = "sobol"
rows = 64
seed = 3
[compute]
what = "modes"
count = 2
chunk = 16
outputs = ["longitudinal_hz"]
"""
DISTURBANCES = b"""load_coulomb = ["0 N m", "0.02 N m"]
backlash = "1 deg"
added_delay = ["0 ms", "1 ms"]
load_factor = [0.5, 3]
cogging = "5 mN m"
cogging_periods = 7
shock_torque = ["-0.1 N m", "0.1 N m"]
shock_time = "0.3 s"
shock_duration = "10 ms"
"""
MOTION = b"time [s],torque [N m],pretension [N],carriage [mm]\n" + b"".join(
    f"{0.01 * k:.2f},{0.1 * (k % 7):.3f},{7 - 0.01 * k:.3f},{250 + k}\n".encode() for k in range(60)
)
WORDS = (
    "nan inf -inf 1e999 -1e-999 0 -1 0x7fffffffffffffff 1_000 --1 1,5 true [[ ]] { } = = [cable] [[pulley]] "
    "1979-05-27T07:32:00Z 2026-02-30T00:00:00 # , ; \\ \\u0000 --- EOF [N m] \u2028 \x85 \uff11 "
    "\ufeff \U0001f600"
)
TOKENS = [word.encode() for word in WORDS.split(" ")]
TOKENS += [b"9" * 400, b"9" * 5000, b"[" * 3000, b"a." * 500, b"x" * 140_000, b'""', b'"5 kg"', b'"-3 %"']
TOKENS += [b"\x00", b"\xff\xfe", b"\xc3(", b"\x0c", b"\t", b"\r", b"\n", b"\r\n", b'"""', b"'''"]
INTEGERS = (0, 1, 0x7F, 0xFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0x10000000)
Sources = list[tuple[str, bytes]]


def mutant(source: bytes, text: bool, rng: random.Random) -> bytes:
    """A file with up to six changes of bytes and, in a text, of words and lines."""
    data = bytearray(source)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 6))):
        deed = rng.choice(
            [_bits, _block, _cut, _insert, _line, _value, _value] if text else [_bits, _block, _cut]
        )
        deed(data, rng)
    return bytes(data)


def _bits(data: bytearray, rng: random.Random) -> None:
    for _ in range(rng.randrange(1, 9) if data else 0):
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)


def _block(data: bytearray, rng: random.Random) -> None:
    """Zeroed, random, odd integers, dropped, repeated or from another place."""
    start, other = rng.randrange(len(data) + 1), rng.randrange(len(data) + 1)
    length = rng.randrange(1, rng.choice((8, 64, 600)))
    taken = bytes(data[start : start + length])
    integers = rng.choice(INTEGERS).to_bytes(4, "little") * rng.randrange(1, 3)
    fresh = (
        bytes(length),
        rng.randbytes(length),
        integers,
        b"",
        2 * taken,
        bytes(data[other : other + length]),
    )
    data[start : start + length] = rng.choice(fresh)


def _cut(data: bytearray, rng: random.Random) -> None:
    del data[rng.randrange(len(data) + 1) :]


def _insert(data: bytearray, rng: random.Random) -> None:
    place = rng.randrange(len(data) + 1)
    data[place:place] = rng.choice(TOKENS)


def _line(data: bytearray, rng: random.Random) -> None:
    """Drop, double or overwrite a line."""
    lines = bytes(data).split(b"\n")
    place = rng.randrange(len(lines))
    other = rng.choice(lines)
    lines[place : place + 1] = rng.choice(([], [other, lines[place]], [other]))
    data[:] = b"\n".join(lines)


def _value(data: bytearray, rng: random.Random) -> None:
    """Another value in a line of a table or of a list."""
    lines = bytes(data).split(b"\n")
    place = rng.randrange(len(lines))
    key, equals, old = lines[place].partition(b"=")
    number = b"%.17g" % (rng.choice((-1.0, 1.0)) * 10.0 ** rng.uniform(-320.0, 308.0))
    fresh = rng.choice([*TOKENS, old[::-1], b"-" + old.strip(), old.strip() + b"0" * 9, number])
    cells = lines[place].split(b",")
    cells[rng.randrange(len(cells))] = fresh
    lines[place] = key + b"= " + fresh if equals else b",".join(cells)
    data[:] = b"\n".join(lines)


def _check(path: Path) -> None:
    main(["check", str(path), "--json"], prog_name="cabledrive")


def _log(path: Path) -> None:
    maps = {
        ".db3": ["time=a.z", "torque=a.x:N m", "angle=a.y:rad"],
        ".mcap": ["time=a.time", "torque=a.torque", "angle=a.angle"],
    }
    if path.name in ("resonances_x.csv", "calibration_data_y.csv", "raw_data_x.csv"):
        spectrum_peaks(read_printer_spectrum(path))
    else:
        read_log(path, with_choices(ColumnMap(), maps.get(path.suffix, [])))


def _excitation(path: Path) -> None:
    check_excitation(load_drive("dissertation-3").two_pulleys, load_excitation(path))


def _routes() -> Sources:
    return [("m.toml", packaged_text(name).encode()) for name in packaged_drives("route")]


def _controllers() -> Sources:
    data = designed(load_drive("dissertation-3").two_pulleys, "darc-4").data
    return [("m.json", json.dumps(data, indent=indent).encode()) for indent in (1, None)]


def _logs() -> Sources:
    with tempfile.TemporaryDirectory() as folder:
        return [(log.name, log.read_bytes()) for log in sound_logs(Path(folder))]


@dataclass(frozen=True, slots=True)
class Kind:
    """What is read by a door, and the least share of it that is still valid when damaged."""

    sources: Callable[[], Sources]
    door: Callable[[Path], object]
    still_valid: float = 0.02


KINDS = {
    "drive": Kind(lambda: [("m.toml", file) for file in FILES], _check),
    "route": Kind(_routes, _check),
    "goals": Kind(lambda: [("m.toml", GOALS)], load_goals),
    "excitation": Kind(lambda: [("m.toml", EXCITATION)], _excitation),
    "motion": Kind(lambda: [("m.csv", MOTION)], read_motion),
    "sweep": Kind(lambda: [("m.toml", SWEEP)], read_spec, 0.01),  # read strictly
    "disturbances": Kind(lambda: [("m.toml", DISTURBANCES)], load_disturbances),
    "controller": Kind(_controllers, read_source),
    "log": Kind(_logs, _log, 0.05),
}


def attack(name: str, seed: int, count: int) -> tuple[Counter[int], list[str], int]:
    """How a batch ended, by status; every case that ended otherwise than it may; largest memory [bytes]."""
    kind, outcomes, bad, largest = KINDS[name], Counter[int](), [], 0
    sources = kind.sources()
    with tempfile.TemporaryDirectory() as folder:
        for file, content in sources:  # what a door loads and compiles, the processes of the cases find done
            path = Path(folder) / file
            path.write_bytes(content)
            with redirect_stdout(io.StringIO()), suppress(SystemExit):
                kind.door(path)
        for number in range(count):
            rng = random.Random(f"{name} {seed} {number}")
            file, content = rng.choice(sources)
            path = Path(folder) / file
            path.write_bytes(mutant(content, path.suffix in (".toml", ".csv", ".json", ".txt", ".tsv"), rng))
            status, errors, seconds, memory = ended(kind.door, path)
            outcomes[status] += 1
            largest = max(largest, memory)
            one_line = errors.count("\n") == 1 if status else "Traceback" not in errors
            if status not in (0, 2, 3) or not one_line or seconds > SECONDS:
                bad.append(
                    f"{name}, seed {seed}, number {number}: {status}, {seconds:.1f} s: {errors[-300:]}"
                )
    return outcomes, bad, largest


def ended(door: Callable[[Path], object], path: Path) -> tuple[int, str, float, int]:
    """Status, standard error, processor time [s] and memory [bytes] of a process that reads a file."""
    errors = os.memfd_create("errors")
    child = os.fork()
    if child == 0:
        _read(door, path, errors)
    _, status, used = os.wait4(child, 0)
    with os.fdopen(errors, "rb") as file:
        file.seek(0)
        words = file.read().decode("utf-8", errors="replace")
    return os.waitstatus_to_exitcode(status), words, used.ru_utime + used.ru_stime, used.ru_maxrss * 1024


def _read(door: Callable[[Path], object], path: Path, errors: int) -> None:
    """The child, which ends as a command does; it never returns."""
    status = 1
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        os.dup2(errors, 2)
        sys.stdout, sys.stderr = (
            os.fdopen(n, "w", buffering=1, closefd=False, encoding="utf-8") for n in (1, 2)
        )
        here = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (here + BYTES, here + BYTES))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(60)
        try:
            status = int(status_of(lambda: door(path) and None) or 0)
        except SystemExit as end:
            status = int(end.code or 0)
    except BaseException:
        os.write(2, traceback.format_exc().encode())
    finally:
        os._exit(status)
