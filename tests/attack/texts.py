"""Damaged files of every kind that is read as text, seeded, through the doors that a command uses.

``python tests/attack/texts.py --seed 1 --count 100000`` adds a batch of each kind to the ledger and prints
how they ended; ``--kind drive`` takes one kind, ``--processes`` runs each in a process of its own, with a
limit on its memory. A case is made from kind, seed and number alone.
"""

import argparse
import contextlib
import io
import json
import random
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from pathlib import Path

if __package__ in (None, ""):
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from attack import ledger

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
SWEEP = b"""drive = "dissertation-2"
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
TOKENS = [
    *(
        b"nan",
        b"inf",
        b"-inf",
        b"1e999",
        b"-1e-999",
        b"0",
        b"-1",
        b"9" * 400,
        b"9" * 5000,
        b"0x7fffffffffffffff",
    ),
    *(
        b"true",
        b'""',
        b'"5 kg"',
        b'"-3 %"',
        b"[[",
        b"]]",
        b"[[]]",
        b"{",
        b"}",
        b"[" * 3000,
        b"a." * 500,
        b"= =",
    ),
    *(
        b"\x00",
        b"\xff\xfe",
        b"\xc3(",
        b"\xf0\x9f\x98\x80",
        b"\xe2\x80\xa8",
        b"\x0c",
        b"\r",
        b"\r\n",
        b'"""',
        b"'''",
    ),
    *(
        b"[cable]",
        b"[[pulley]]",
        b"[[carriage]]",
        b"1979-05-27T07:32:00Z",
        b"#",
        b",",
        b";",
        b"\t",
        b"\\u0000",
    ),
]


def mutant(sources: list[bytes], rng: random.Random) -> bytes:
    """One of the sources with up to six changes of bytes, words or lines."""
    data = bytearray(rng.choice(sources))
    for _ in range(rng.choice((1, 1, 1, 2, 3, 6))):
        rng.choice(DEEDS)(data, sources, rng)
    return bytes(data)


def _flip(data: bytearray, sources: list[bytes], rng: random.Random) -> None:
    if data:
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)


def _insert(data: bytearray, sources: list[bytes], rng: random.Random) -> None:
    place = rng.randrange(len(data) + 1)
    data[place:place] = rng.choice(TOKENS)


def _cut(data: bytearray, sources: list[bytes], rng: random.Random) -> None:
    del data[rng.randrange(len(data) + 1) :]


def _lines(data: bytearray, sources: list[bytes], rng: random.Random) -> None:
    """Drop, double, move or take a line from another source."""
    lines = bytes(data).split(b"\n")
    taken = rng.choice([lines, rng.choice(sources).split(b"\n")])
    place = rng.randrange(len(lines))
    deed = rng.randrange(3)
    if deed == 0:
        del lines[place]
    elif deed == 1:
        lines.insert(place, rng.choice(taken))
    else:
        lines[place] = rng.choice(taken)
    data[:] = b"\n".join(lines)


def _value(data: bytearray, sources: list[bytes], rng: random.Random) -> None:
    """Another value in a line."""
    lines = bytes(data).split(b"\n")
    place = rng.randrange(len(lines))
    key, equals, old = lines[place].partition(b"=")
    fresh = rng.choice(
        [*TOKENS, old[::-1], b"-" + old.strip(), old.strip() + b"0" * 9, b"%.17g" % _number(rng)]
    )
    if equals:
        lines[place] = key + b"= " + fresh
    else:
        cells = lines[place].split(b",")
        cells[rng.randrange(len(cells))] = fresh
        lines[place] = b",".join(cells)
    data[:] = b"\n".join(lines)


def _number(rng: random.Random) -> float:
    return rng.choice((-1.0, 1.0)) * 10.0 ** rng.uniform(-320.0, 308.0)


def _digits(data: bytearray, sources: list[bytes], rng: random.Random) -> None:
    """A digit, a sign, a point or a unit's letter in place of another."""
    places = [k for k, byte in enumerate(data) if byte in b"0123456789.-emNkg"]
    if places:
        data[rng.choice(places)] = rng.choice(b"0123456789.-+emNkg /^%")


def _block(data: bytearray, sources: list[bytes], rng: random.Random) -> None:
    start = rng.randrange(len(data) + 1)
    length = rng.randrange(1, 64)
    other = rng.choice([bytes(length), rng.randbytes(length), bytes(data[start : start + length]) * 2])
    data[start : start + length] = other


DEEDS = [_flip, _insert, _cut, _lines, _lines, _value, _value, _value, _digits, _digits, _block]


def _drives() -> list[bytes]:
    from drive_mutations import FILES

    return list(FILES)


def _routes() -> list[bytes]:
    from cabledrive.parameters import packaged_drives
    from cabledrive.parameters.drive_file import packaged_text

    return [packaged_text(name).encode() for name in packaged_drives("route")]


def _controllers() -> list[bytes]:
    from cabledrive.export.source import designed
    from cabledrive.parameters import load_drive

    data = designed(load_drive("dissertation-3"), "darc-4").data
    return [json.dumps(data, indent=1).encode(), json.dumps(data).encode()]


def _check(path: Path) -> None:
    """What `cabledrive check FILE --json` does, in this process."""
    from cabledrive.app.main import main

    main(["check", str(path), "--json"], prog_name="cabledrive")


def _goals(path: Path) -> None:
    from cabledrive.studies.study import load_goals

    _ending(lambda: load_goals(path))


def _excitation(path: Path) -> None:
    from cabledrive.app.run_limits import check_excitation
    from cabledrive.parameters import load_drive
    from cabledrive.rig.bench.experiment import load_excitation

    _ending(lambda: check_excitation(load_drive("dissertation-3"), load_excitation(path)))


def _motion(path: Path) -> None:
    from cabledrive.studies.motion_file import read_motion

    _ending(lambda: read_motion(path))


def _sweep(path: Path) -> None:
    from cabledrive.campaign.spec import read_spec

    _ending(lambda: read_spec(path))


def _disturbances(path: Path) -> None:
    from cabledrive.rig.disturbed.disturbances_file import load_disturbances

    _ending(lambda: load_disturbances(path))


def _controller(path: Path) -> None:
    from cabledrive.export.source import read_source

    _ending(lambda: read_source(path))


def _ending(run: Callable[[], object]) -> None:
    """As the command ends when this is what it does first."""
    from cabledrive.app.failures import status_of

    raise SystemExit(status_of(lambda: run() and None))


KINDS: dict[str, tuple[str, Callable[[], list[bytes]], Callable[[Path], None]]] = {
    "drive": (".toml", _drives, _check),
    "goals": (".toml", lambda: [GOALS], _goals),
    "excitation": (".toml", lambda: [EXCITATION], _excitation),
    "motion": (".csv", lambda: [MOTION], _motion),
    "route": (".toml", _routes, _check),
    "sweep": (".toml", lambda: [SWEEP], _sweep),
    "disturbances": (".toml", lambda: [DISTURBANCES], _disturbances),
    "controller": (".json", _controllers, _controller),
}


def attack(kind: str, seed: int, count: int, *, first: int = 0) -> tuple[Counter[str], list[str]]:
    """How a batch ended, by status, and every case that ended otherwise than it may."""
    suffix, sources, door = KINDS[kind]
    whole, outcomes, bad = sources(), Counter[str](), []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"mutant{suffix}"
        for number in range(first, first + count):
            path.write_bytes(mutant(whole, random.Random(f"{kind} {seed} {number}")))
            status, errors, seconds = ended(door, path)
            fault = fault_of(status, errors, seconds)
            outcomes[fault or str(status)] += 1
            if fault:
                bad.append(f"{kind}, seed {seed}, number {number}: {fault}, status {status}: {errors[-300:]}")
    return outcomes, bad


def fault_of(status: int, errors: str, seconds: float) -> str:
    """What is wrong with an ending; nothing where it is as promised."""
    if status not in (0, 2, 3):
        return "defect"
    if (status == 0 and "Traceback" in errors) or (status and errors.count("\n") != 1):
        return "lines"
    return "slow" if seconds > SECONDS else ""


def ended(door: Callable[[Path], None], path: Path) -> tuple[int, str, float]:
    """Status, standard error and time [s] of a door that ends as a command does."""
    output, errors, status = io.StringIO(), io.StringIO(), 1
    began = time.process_time()
    with contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors), _at_most(60):
        try:
            door(path)
        except SystemExit as end:
            status = int(end.code or 0)
        except BaseException:
            errors.write(traceback.format_exc())
    return status, errors.getvalue(), time.process_time() - began


@contextlib.contextmanager
def _at_most(seconds: int):
    def late(*arguments: object) -> None:
        raise TimeoutError(f"{seconds} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def attack_in_processes(seed: int, count: int) -> tuple[Counter[str], list[str], int]:
    """Drive files, each checked by a process of its own, with 2 GiB beyond what the libraries take."""
    from attack.nursery import Nursery

    whole, outcomes, bad, largest = _drives(), Counter[str](), [], 0
    with tempfile.TemporaryDirectory() as folder, Nursery() as nursery:
        path = Path(folder) / "mutant.toml"
        for number in range(count):
            path.write_bytes(mutant(whole, random.Random(f"processes {seed} {number}")))
            limits = {"memory": BYTES + (3 << 30), "seconds": 60.0}  # killed after that
            done = nursery.run("check", path, "--json", folder=Path(folder), **limits)
            largest = max(largest, done.largest)
            fault = fault_of(done.status, done.errors, done.processor)  # the machine may be shared
            outcomes[fault or str(done.status)] += 1
            if fault:
                bad.append(
                    f"processes, seed {seed}, number {number}: {fault}: {done.status} {done.errors[-300:]}"
                )
    return outcomes, bad, largest


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--kind", choices=KINDS, action="append")
    parser.add_argument("--processes", action="store_true")
    given = parser.parse_args()
    for kind in ["processes"] if given.processes else given.kind or KINDS:
        began = time.process_time()
        if kind == "processes":
            outcomes, bad, _ = attack_in_processes(given.seed, given.count)
        else:
            outcomes, bad = attack(kind, given.seed, given.count)
        ledger.note(kind, given.seed, outcomes)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(
            *bad[:40],
            f"{kind}: {dict(outcomes)}, {time.process_time() - began:.0f} s, {peak:.0f} MiB",
            sep="\n",
        )
    print({kind: dict(found) for kind, found in ledger.totals().items()})
