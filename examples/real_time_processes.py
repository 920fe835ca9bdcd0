"""How does an exported controller keep time? Plant and controller as two processes over a socket pair."""

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import cabledrive as cd

HERE = Path(__file__).parent / "real_time"
SECONDS = sys.argv[1] if len(sys.argv) > 1 else "0.5"
PARTS = {"controller": "cabledrive_law.c", "plant": "cabledrive_plant.c"}

if shutil.which("cc") is None or sys.platform != "linux":
    print("needs Linux and a C compiler")
    raise SystemExit
with tempfile.TemporaryDirectory() as place:
    for what, source in PARTS.items():
        folder = Path(place) / f"exported_{what}"
        cd.export_to(folder, "dissertation-3", "c99", controller="lqg", what=what)
        flags = ["-std=c11", "-O2", "-ffp-contract=off", "-I", str(folder), "-I", str(HERE)]
        files = [str(HERE / f"{what}.c"), str(folder / source)]
        subprocess.run(["cc", *flags, *files, "-lm", "-o", f"{place}/{what}"], check=True)
    command = [f"{place}/plant", SECONDS, f"{place}/controller"]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    print(done.stdout)
    counts = re.search(r"^samples (\d+), deadlines missed (\d+)", done.stdout, re.M)
    samples, missed = (int(number) for number in counts.groups())
    assert samples == round(float(SECONDS) / 2e-4)
    assert missed <= samples
