"""Every command that writes, stopped at each of its own writes: killed, interrupted, out of power, refused.

A moment is the n-th call by which a command opens, writes, syncs, renames, deletes or makes something in its
folder (`faults.c`).
"""

import errno
import json
import random
import shutil
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from attack.nursery import COUNT, FAIL, FAIL_FROM_HERE, INTERRUPT, KILL, Ended, Nursery, compiled_faults

BLOCK = 512
CAUSES = {
    errno.ENOSPC: "No space left on device",
    errno.EDQUOT: "Disk quota exceeded",
    errno.EROFS: "Read-only file system",
    errno.EACCES: "Permission denied",
    errno.EIO: "Input/output error",
}
QUIET = ["--quiet"]
PATIENT = {"cabledrive.simulation.run:NODE_STEPS_PER_CHUNK": 3000}
CHUNKS = PATIENT | {"cabledrive.simulation.run:SECONDS_PER_COMMIT": 0.0}
GOALS = '[motion]\nduration = "0.3 s"\ndwell = "0.1 s"\n[acceptance]\ndraws = 2\ncable_draws = 0\n'
SWEEP = """drive = "dissertation-2"
[vary]
"pulley.1.inertia" = { from = "20 kg cm^2", to = "26 kg cm^2" }
[design]
kind = "sobol"
rows = 64
seed = 3
[compute]
what = "modes"
count = 2
chunk = 16
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """A command that writes to the current folder, and what adding ``go_on`` to it goes on with.

    ``written``: patterns of files that are the same to the byte however often the run was stopped. ``keeps``:
    finished parts are kept in its folder while it works. ``replaces``: it has ``--force``.
    """

    arguments: list[str]
    written: tuple[str, ...]
    go_on: list[str] = field(default_factory=list)
    keeps: bool = False
    replaces: bool = True


RUN = ["simulate", "dissertation-2", "--duration", "0.02", "--segments", "12", "--rate", "5000"]
RUN += ["--fields", "7", "--pluck-upper", "1 mm", "--torque-amplitude", "0.02", "--torque-frequency", "81.7"]
TRACKED = ["track", "dissertation-3", "--controller", "pd", "--rise", "0.3", "--dwell", "0.05"]
COMPARED = ["compare", "dissertation-3", "--controllers", "lqi", "--draws", "2", "--pulses", "1"]
COMMANDS = {
    "simulate": Command(arguments=[*RUN, "-o", "r.nc"], written=("r.nc",), go_on=["--resume"]),
    "fast": Command(
        arguments=["simulate", "dissertation-2", "--model", "fast", "--duration", "0.02", "-o", "r.nc"],
        written=("r.nc",),
    ),
    "modes": Command(arguments=["modes", "dissertation-2", "-o", "m.json"], written=("m.json",)),
    "track": Command(arguments=[*TRACKED, "-o", "t.json", "--log", "t.csv"], written=("t.csv",)),
    "study": Command(
        arguments=["study", "dissertation-3", "--goals", "../goals.toml", "-o", "s"],
        written=("s/results.json", "s/drive.toml", "s/controller.json"),
        keeps=True,
    ),
    "compare": Command(arguments=[*COMPARED, "-o", "c"], written=("c/stages/runs-*",), keeps=True),
    "export": Command(
        arguments=["export", "dissertation-3", "--format", "c99", "--controller", "lqg", "-o", "e"],
        written=("e/*",),
        replaces=False,
    ),
    "sweep": Command(
        arguments=["sweep", "../sweep.toml", "--part", "1/1", "-o", "w.zarr"],
        written=("w.zarr/longitudinal_*/c/**/*", "w.zarr/code/c/*", "w.zarr/seed/c/*", "w.zarr/pulley*/c/*"),
        keeps=True,
        replaces=False,
    ),
}
KINDS = ("kill", "interrupt", "power", "full", "fault")


class Attack:
    """A nursery, and the bytes and the number of moments of every command when nothing stops it."""

    def __init__(self, nursery: Nursery, folder: Path) -> None:
        self.nursery, self.folder = nursery, folder
        (folder / "goals.toml").write_text(GOALS)
        (folder / "sweep.toml").write_text(SWEEP)
        self._known: dict[str, tuple[dict[str, bytes], int]] = {}

    def whole(self, name: str) -> tuple[dict[str, bytes], int]:
        """What a command writes when nothing stops it, and at how many moments."""
        if name not in self._known:
            self._known[name] = self._undisturbed(name)
        return self._known[name]

    def _undisturbed(self, name: str) -> tuple[dict[str, bytes], int]:
        place = self._fresh("whole")
        done = self._run(name, place, mode=COUNT)
        files = self._files(name, place)
        assert done.status == 0, done
        assert files, name
        return files, done.calls

    def _files(self, name: str, place: Path) -> dict[str, bytes]:
        found = [file for pattern in COMMANDS[name].written for file in place.glob(pattern)]
        files = [
            file for file in found if file.is_file() and file.suffix != ".partial"
        ]  # of zarr, never read
        return {str(file.relative_to(place)): _timeless(file) for file in files}

    def _fresh(self, name: str) -> Path:
        place = self.folder / name
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir()
        return place

    def _run(self, name: str, place: Path, *more: str, **options: Any) -> Ended:
        armed = {"root": str(place), "journal": str(self.folder / "journal")} if "mode" in options else {}
        (self.folder / "journal").unlink(missing_ok=True)
        return self.nursery.run(
            *COMMANDS[name].arguments,
            *QUIET,
            *more,
            folder=place,
            set=CHUNKS,
            seconds=900.0,
            **armed,
            **options,
        )

    def at(self, name: str, kind: str, moment: int, rng: random.Random) -> str:
        """What is wrong with a command that was stopped at a moment; nothing if all is as promised."""
        place = self._fresh("stopped")
        number = rng.choice([*CAUSES])
        if kind in ("kill", "power"):
            first = self._run(name, place, mode=KILL, at=moment)
            if kind == "power":
                _lose_power(place, self.folder / "journal", rng)
        elif kind == "interrupt":
            first = self._run(name, place, mode=INTERRUPT, at=moment)
        else:
            mode = FAIL_FROM_HERE if kind == "full" else FAIL
            first = self._run(name, place, mode=mode, at=moment, error=number)
        fault = _ending_fault(first, kind, CAUSES[number])
        return fault or self._going_on_fault(name, place, first)

    def _going_on_fault(self, name: str, place: Path, first: Ended) -> str:
        """The same command ends with the same bytes, or is refused and does so with force."""
        if first.status == 0 and self._files(name, place) != self.whole(name)[0]:
            return "status 0 and other bytes"
        again = self._run(name, place, *COMMANDS[name].go_on)
        if again.status == 2 and again.errors.count("\n") == 1 and self._untouched(name, place):
            if not COMMANDS[name].replaces:
                return ""
            again = self._run(name, place, "--force")
        if again.status != 0:
            return f"going on ended with {again.status}: {again.errors[-300:]}"
        return "" if self._files(name, place) == self.whole(name)[0] else "other bytes after going on"

    def _untouched(self, name: str, place: Path) -> bool:
        """What is there under a result's name is a whole result."""
        if COMMANDS[name].replaces and COMMANDS[name].keeps:
            return True
        found, whole = self._files(name, place), self.whole(name)[0]
        return found == whole if not COMMANDS[name].replaces else found.items() <= whole.items()


def _ending_fault(first: Ended, kind: str, cause: str) -> str:
    """What is wrong with the status and the lines of a command that was stopped."""
    lines = [line for line in first.errors.splitlines() if line]
    message = f"status {first.status}, {first.errors[-300:]!r}"
    if kind in ("kill", "power"):
        return "" if first.status in (-9, 0) else message
    if kind == "interrupt":
        right = (first.status == 130 and len(lines) == 1) or (first.status == 0 and not lines)
        return "" if right else message
    if first.status == 0:
        return "" if not lines else message
    return "" if first.status in (2, 3) and len(lines) == 1 and cause in lines[0] else message


def _timeless(file: Path) -> bytes:
    """The bytes of a file; of JSON without when it was made, in how long, and the hashes of that."""
    content = file.read_bytes()
    if file.suffix != ".json":
        return content
    return json.dumps(_without(json.loads(content), {"seconds", "sha256", "files", "provenance"})).encode()


def _without(value: Any, keys: set[str]) -> Any:
    if isinstance(value, dict):
        return {key: _without(one, keys) for key, one in value.items() if key not in keys}
    return [_without(one, keys) for one in value] if isinstance(value, list) else value


def _lose_power(place: Path, journal: Path, rng: random.Random) -> None:
    """Take back, from each file, blocks that were written since it was last synced."""
    dirty: dict[str, int] = {}
    for line in journal.read_text().splitlines() if journal.exists() else ():
        kind, size, path = line.split(" ", 2)
        if kind == "S":
            dirty.pop(path, None)
        elif kind == "W":
            dirty[path] = min(dirty.get(path, int(size)), int(size))
        else:
            source, _, target = path.partition("\t")
            if source in dirty:
                dirty[target] = dirty.pop(source)
    for path, safe in dirty.items():
        file = Path(path)
        if place in file.parents and file.exists():
            content = bytearray(file.read_bytes())
            if rng.random() < 0.5:
                content = content[: rng.randrange(safe, len(content) + 1) if len(content) > safe else safe]
            for start in range(safe, len(content), BLOCK):
                if rng.random() < 0.5:
                    stop = min(start + BLOCK, len(content))
                    content[start:stop] = bytes(stop - start)
            file.write_bytes(content)


@contextmanager
def attacker(folder: Path) -> Iterator[Attack | None]:
    """An attack that is ready; None where no faults can be made here."""
    library = compiled_faults(folder)
    if library is None:
        yield None
        return
    (folder / "attacked").mkdir()
    with Nursery(library=library) as nursery:
        yield Attack(nursery, folder / "attacked")


def batch(attack: Attack, seed: int, count: int, names: list[str]) -> tuple[Counter[str], list[str]]:
    """Outcomes of moments drawn at random, each command and kind in turn, and every bad one."""
    outcomes, bad = Counter[str](), []
    for number in range(count):
        rng = random.Random(f"moments {seed} {number}")
        name, kind = names[number % len(names)], KINDS[(number // len(names)) % len(KINDS)]
        moment = rng.randrange(1, attack.whole(name)[1] + 1)
        fault = attack.at(name, kind, moment, rng)
        outcomes[f"{kind}: {'wrong' if fault else 'as promised'}"] += 1
        if fault:
            place = f"{moment} of {attack.whole(name)[1]} (seed {seed}, number {number})"
            bad.append(f"{name}, {kind} at {place}: {fault}")
    return outcomes, bad
