"""A log read block by block gives what it gives at once."""

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet

from cabledrive.identification.logs import reading
from cabledrive.identification.logs.reading import open_log
from cabledrive.identification.long_logs import identify_long_log, is_long
from cabledrive.identification.one_log import IdentifyOptions, identify
from cabledrive.parameters import InputRefused
from cabledrive.rig.bench.chapter_4 import BENCH_TESTS, bench_command, bench_rig
from cabledrive.rig.bench.virtual_rig import run_rig

TEST = BENCH_TESTS[1]


@pytest.fixture
def path(tmp_path):
    rng = np.random.default_rng(5)
    log = run_rig(bench_rig(TEST), bench_command(TEST, rng), rng)
    columns = {
        "time [s]": log.time,
        "torque [N m]": log.channel("torque"),
        "angle [rad]": log.channel("angle"),
    }
    parquet.write_table(pa.table(columns), tmp_path / "log.parquet")
    return tmp_path / "log.parquet"


def test_blocks_give_the_parameters_of_the_whole_log(path, monkeypatch):
    """Apart from filter ends and the bandwidth of the first block: within half a standard error."""
    whole = identify(path, IdentifyOptions(check=False))
    monkeypatch.setattr("cabledrive.identification.long_logs.BLOCK_ROWS", 17_000)
    monkeypatch.setattr("cabledrive.identification.logs.parquet.BLOCK_ROWS", 5_000)
    blocks = identify_long_log(open_log(path))
    assert blocks.method["blocks"] == 4
    assert blocks.reports[0].rows == 70_000
    for name, estimate in whole.parameters.items():
        off = abs(blocks[name] - estimate.value) / estimate.standard_error
        assert off < 0.5, f"{name}: {off:.2f} standard errors"


def test_a_long_log_is_read_in_blocks_by_itself(path, monkeypatch):
    monkeypatch.setattr("cabledrive.identification.long_logs.MOST_VALUES", 1000)
    assert is_long(open_log(path))
    assert "blocks" in identify(path).method


def test_a_log_too_long_for_memory_is_refused_where_blocks_do_not_serve(path, monkeypatch):
    monkeypatch.setattr(reading, "MOST_VALUES", 1000)
    with pytest.raises(InputRefused, match="more than 1000 numbers"):
        reading.read_log(path)


def csv_of(path, folder):
    columns = parquet.read_table(path).to_pydict()
    rows = (",".join(f"{cell:.9g}" for cell in row) for row in zip(*columns.values(), strict=True))
    (folder / "log.csv").write_text("\n".join([",".join(columns), *rows]) + "\n")
    return folder / "log.csv"


def test_a_text_log_is_read_in_blocks_with_progress(path, tmp_path, monkeypatch):
    """CSV of which no more is held than a block: the parameters of the whole, and a line for every block."""
    text = csv_of(path, tmp_path)
    whole = identify(text, IdentifyOptions(check=False))
    monkeypatch.setattr("cabledrive.identification.long_logs.MOST_VALUES", 100_000)
    monkeypatch.setattr("cabledrive.identification.long_logs.BLOCK_ROWS", 17_000)
    monkeypatch.setattr("cabledrive.identification.logs.lines.BLOCK_BYTES", 100_000)
    lines = []
    blocks = identify(text, progress=lines.append)
    assert (blocks.method["blocks"], blocks.reports[0].rows) == (4, 70_000)
    assert lines[-1].startswith("log.csv: 70000 rows, about 9")
    assert len(lines) == 4
    for name, estimate in whole.parameters.items():
        off = abs(blocks[name] - estimate.value) / estimate.standard_error
        assert off < 0.5, f"{name}: {off:.2f} standard errors"


def test_blocks_in_which_nothing_moves_are_left_out_and_said(path, tmp_path, monkeypatch):
    """The machine rests for two blocks: the parameters stay, the report counts the rows."""
    columns = {name: np.array(values) for name, values in parquet.read_table(path).to_pydict().items()}
    first, step = (values[0] for values in columns.values()), 1e-3
    still = dict(zip(columns, (np.full(34_000, value) for value in first), strict=True))
    still["time [s]"] = columns["time [s]"][-1] + step * np.arange(1, 34_001)
    joined = {name: np.concatenate([columns[name][:68_000], still[name]]) for name in columns}
    joined["time [s]"] = step * np.arange(102_000)
    parquet.write_table(pa.table(joined), tmp_path / "rest.parquet")
    monkeypatch.setattr("cabledrive.identification.long_logs.BLOCK_ROWS", 17_000)
    found, whole = identify_long_log(open_log(tmp_path / "rest.parquet")), identify_long_log(open_log(path))
    assert "34000 rows in blocks in which nothing moves" in found.reports[0].findings[-1]
    assert found["inertia"] == pytest.approx(whole["inertia"], rel=1e-3)
