"""Run the benchmark cases and print their tables in Markdown: ``python benchmarks/run.py [case ...]``.

A case is a file ``case_NAME.py`` in this folder with a docstring, a `TITLE` and a function `report` that
returns text. To add one, add the file.
"""

import argparse
import os
import sys
from importlib import import_module
from pathlib import Path

HERE = Path(__file__).resolve().parent


def main() -> int:
    """Run the cases that are named, or all of them, in alphabetical order."""
    cases = sorted(path.stem.removeprefix("case_") for path in HERE.glob("case_*.py"))
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "cases", nargs="*", metavar="case", help=f"of {', '.join(cases)}; all if none is named"
    )
    chosen = parser.parse_args().cases or cases
    unknown = [name for name in chosen if name not in cases]
    if unknown:
        parser.error(f"no case {', '.join(unknown)}: choose from {', '.join(cases)}")
    for library in ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "NUMBA"):  # before any of them is loaded
        os.environ[f"{library}_NUM_THREADS"] = "1"
    sys.path[:0] = [str(HERE), str(HERE.parent)]  # the cases, and what of the dissertation they compare
    from harness import ROUNDS, machine, one_core

    one_core()
    print(
        f"Processor time, medians of {ROUNDS} rounds in turns ± half the interquartile range.\n{machine()}."
    )
    for name in chosen:
        case = import_module(f"case_{name}")
        print(f"\n## {case.TITLE}\n\n{case.report()}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
