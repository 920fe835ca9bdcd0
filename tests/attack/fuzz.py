"""Coverage-guided fuzzing of every file that is read as text: drive, route, goals, motion, SPEC, controller.

``python tests/attack/fuzz.py --kind drive --seconds 900 FOLDER`` needs ``pip install atheris``, which is no
dependency of the package. Inputs that reach new code are kept in FOLDER and are where the next run begins;
an input that ends otherwise than it may is written to FOLDER/found, and the run goes on.
"""

import argparse
import sys
import tempfile
import time
from collections import Counter
from importlib import import_module
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import atheris

HOUSE = ("cabledrive.parameters", "cabledrive.studies", "cabledrive.campaign", "cabledrive.rig.laws")

with atheris.instrument_imports(include=["tomllib", *HOUSE]):
    for name in ("app.main", "campaign.spec", "rig.laws.controller_file", "studies.motion_file"):
        import_module(f"cabledrive.{name}")
    from attack import ledger, texts


def fuzz(kind: str, seconds: float, folder: Path) -> None:
    """Fuzz one door for a time; never returns, the fuzzing engine ends the process."""
    suffix, sources, door = texts.KINDS[kind]
    corpus, found = folder / kind, folder / "found"
    for place in (corpus, found):
        place.mkdir(parents=True, exist_ok=True)
    for number, source in enumerate(sources()):
        (corpus / f"source-{number}").write_bytes(source)
    words = folder / "words.dict"
    words.write_text("".join(f'"{_escaped(word)}"\n' for word in sorted(_words(sources())) if word))
    path = Path(tempfile.mkdtemp()) / f"input{suffix}"
    outcomes, began, number = Counter[str](), time.monotonic(), int(time.time())

    def once(data: bytes) -> None:
        path.write_bytes(data)
        status, errors, spent = texts.ended(door, path)
        fault = texts.fault_of(status, errors, spent)
        outcomes[fault or str(status)] += 1
        if fault:
            (found / f"{kind}-{abs(hash(errors))}{suffix}").write_bytes(data)
            print(f"{kind}: {fault}, status {status}: {errors[-300:]}", flush=True)
        if sum(outcomes.values()) % 500 == 0 or time.monotonic() - began > seconds:
            ledger.note(f"fuzz {kind}", number, outcomes)

    options = [f"-max_total_time={seconds:.0f}", "-max_len=6000", "-timeout=60", f"-dict={words}"]
    atheris.Setup([sys.argv[0], *options, "-print_final_stats=1", str(corpus)], once)
    atheris.Fuzz()


def _words(sources: list[bytes]) -> set[bytes]:
    """Keys, units and odd values: what a fuzzer would not guess."""
    found = {part.strip(b'"[]{},=') for source in sources for part in source.split()}
    return {word for word in found | set(texts.TOKENS) if len(word) < 40}


def _escaped(word: bytes) -> str:
    return "".join(f"\\x{byte:02x}" for byte in word)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=Path)
    parser.add_argument("--kind", choices=texts.KINDS, default="drive")
    parser.add_argument("--seconds", type=float, default=3600.0)
    given = parser.parse_args()
    fuzz(given.kind, given.seconds, given.folder)
