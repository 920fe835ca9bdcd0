"""A SPEC that campaigns are interrupted with, and their stores compared byte by byte."""

from pathlib import Path


def contents(store: Path) -> dict[str, bytes]:
    """All files of a store but those of the times that rows took."""
    files = (path for path in store.rglob("*") if path.is_file())
    named = {str(path.relative_to(store)): path for path in files}
    return {name: path.read_bytes() for name, path in named.items() if not name.startswith("time/")}


def transporter_modes(*, rows: int, chunk: int) -> str:
    """SPEC of rows that take some milliseconds each."""
    return f"""
drive = "dissertation-transporter"
[vary]
"cable.pretension" = {{ from = "3 N", to = "9 N" }}
[design]
kind = "random"
rows = {rows}
[compute]
what = "modes"
chunk = {chunk}
count = 8
"""
