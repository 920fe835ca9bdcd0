"""The door to every log file: regular files only, the format by its ending, one line for what is damaged."""

import re
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from cabledrive.identification.logs.delimited import open_delimited
from cabledrive.identification.logs.hierarchical import open_netcdf
from cabledrive.identification.logs.matlab import open_matlab
from cabledrive.identification.logs.mcap import open_mcap
from cabledrive.identification.logs.parquet import open_parquet
from cabledrive.identification.logs.rosbag import open_rosbag
from cabledrive.identification.logs.table import Blocks, Reading, Table
from cabledrive.parameters import InputRefused
from cabledrive.parameters.files import require_regular

FORMATS: dict[str, Callable[[Path, Reading], Table]] = {
    ".csv": open_delimited,
    ".tsv": open_delimited,
    ".txt": open_delimited,
    ".dat": open_delimited,
    ".parquet": open_parquet,
    ".mat": open_matlab,
    ".nc": open_netcdf,
    ".h5": open_netcdf,
    ".mcap": open_mcap,
    ".db3": open_rosbag,
}
TEXTS = (".csv", ".tsv", ".txt", ".dat")
LONGEST_CAUSE = 110


def open_table(path: str | Path, reading: Reading | None = None, *, text: bool = False) -> Table:
    """Open a log file of any format; only its head is read, or all of it where its format asks for that.

    ``text``: take the file for a text table whatever its ending is.
    Returns whatever its library raises, while opening or reading, is an `InputRefused`.
    Raises `InputRefused` if it is no regular file, is empty, has an ending of no log, is damaged, or cannot
    be read.
    """
    path, reading = Path(path), reading or Reading()
    require_regular(path, "give the path of a log")
    ending = ".csv" if text else path.suffix.lower()
    if ending not in FORMATS:
        raise InputRefused(
            f"{path.name}: logs end in {', '.join(FORMATS)}: unpack compressed files, rename others"
        )
    if path.stat().st_size == 0:
        raise InputRefused(f"{path.name}: is empty: give a log with a header and rows of numbers")
    if reading.skip_rows and ending not in TEXTS:
        raise InputRefused(f"{path.name}: --skip-rows is for text logs ({', '.join(TEXTS)}): leave it out")
    with readable(path.name):
        table = FORMATS[ending](path, reading)
    if not table.names:
        raise InputRefused(f"{path.name}: holds no column of numbers: save the channels as vectors")

    def read(names: tuple[str, ...]) -> Blocks:
        blocks = iter(table.read(names))
        while True:
            with readable(path.name):
                block = next(blocks, None)
            if block is None:
                return
            yield block

    return replace(table, read=read)


@contextmanager
def readable(source: str) -> Iterator[None]:
    """Turn whatever a library raises over a file into one refusal.

    ``source``: name of the file.
    Raises `InputRefused` if anything is raised but an interrupt.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of the libraries, about files that they read all the same
            yield
    except InputRefused:
        raise
    except MemoryError:
        raise InputRefused(
            f"{source}: is damaged, or holds more than fits into memory: write it again, in smaller parts"
        ) from None
    except Exception as error:  # libraries raise many kinds for a damaged file
        cause = re.sub(r"\s+", " ", getattr(error, "strerror", None) or str(error) or type(error).__name__)
        raise InputRefused(
            f"{source}: is damaged or unreadable ({cause[:LONGEST_CAUSE]}): write it again"
        ) from None
