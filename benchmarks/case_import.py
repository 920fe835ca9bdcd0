"""What `import cabledrive` costs, and what it does not load."""

import subprocess
import sys

from harness import duration, side_by_side, table

TITLE = "Import"
LIMIT = 0.5
HEAVY = ("matplotlib", "pint", "numba", "scipy", "xarray")


def report() -> str:
    statements = {
        "python, nothing imported": "pass",
        "numpy": "import numpy",
        "cabledrive": "import cabledrive",
    }
    times = side_by_side({name: lambda code=code: run(code) for name, code in statements.items()})
    rows = [(name, duration(timing)) for name, timing in times.items()]
    listing = f"import cabledrive, sys; print([m for m in {HEAVY} if m in sys.modules])"
    loaded = run(listing).strip()
    note = (
        f"Whole processes. Target: less than {LIMIT} s, and none of {', '.join(HEAVY)} loaded; "
        f"loaded after `import cabledrive`: {loaded}."
    )
    return table(["process", "time"], rows) + "\n\n" + note


def run(code: str) -> str:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
