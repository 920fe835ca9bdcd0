"""Kernels on disk: a damaged file is made again, a full disk does no harm, nobody else's file is loaded."""

import errno
import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from cabledrive.mechanics import compiled

numba = pytest.importorskip("numba")
pytestmark = pytest.mark.skipif(not compiled.numba_at_hand(), reason="kernels are not compiled here")


def scaled(factor, values):
    return factor * values[0]


def kernel(folder):
    """The function, compiled by a process that has compiled nothing yet."""
    from cabledrive.mechanics.kernel_cache import KernelCache

    made = numba.njit(scaled)
    made._cache = KernelCache(scaled, folder)
    return made


def value(folder):
    """Its value, and whether it was loaded."""
    made = kernel(folder)
    return made(2.0, (21.0,)), sum(made.stats.cache_hits.values())


DAMAGES = {
    "whole": lambda content: content,
    "empty": lambda content: b"",
    "cut": lambda content: content[: len(content) // 2],
    "zeros at the start": lambda content: bytes(512) + content[512:],
    "a block of zeros": lambda content: content[:1024] + bytes(512) + content[1536:],
    "all zeros": lambda content: bytes(len(content)),
    "another program's": lambda content: b"\x80\x05]\x94.",
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_kernel_is_deleted_and_made_again(tmp_path, damage, measured):
    assert value(tmp_path) == (42.0, 0)
    (file,) = tmp_path.iterdir()
    whole = file.read_bytes()
    file.write_bytes(DAMAGES[damage](whole))
    found = [value(tmp_path), value(tmp_path)]
    measured(f"{damage}: loads {found[0][1]}, then {found[1][1]}")
    assert found == [(42.0, int(damage == "whole")), (42.0, 1)]
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES])
def test_where_no_kernel_can_be_kept_it_is_compiled_and_nothing_is_left(tmp_path, monkeypatch, number):
    def refuse(*arguments):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "replace", refuse)
    assert value(tmp_path) == (42.0, 0)
    assert list(tmp_path.iterdir()) == []


def test_a_kernel_that_others_could_have_written_is_not_loaded(tmp_path):
    value(tmp_path)
    (file,) = tmp_path.iterdir()
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    file.chmod(0o666)
    assert value(tmp_path) == (42.0, 0)


def test_two_signatures_never_share_a_file(tmp_path):
    made = kernel(tmp_path)
    assert (made(2.0, (21.0,)), made(2, (21,)), made(2.0, (1, 2))) == (42.0, 42, 2.0)
    assert len(list(tmp_path.iterdir())) == 3
    again = kernel(tmp_path)
    assert (again(2, (21,)), again(2.0, (1, 2)), again(2.0, (21.0,))) == (42, 2.0, 42.0)
    assert sum(again.stats.cache_hits.values()) == 3


COLD = """
import sys, time
from pathlib import Path
import test_kernel_cache as t
made = t.kernel(Path(sys.argv[1]))
while time.time() < float(sys.argv[2]): pass
x = int(sys.argv[3])
print(made((2.0, 2)[x], ((21.0,), (21,))[x]), made((2, 2.0)[x], ((21,), (21.0,))[x]))
"""


@pytest.mark.verify
def test_cold_processes_side_by_side_cross_no_kernels(tmp_path, measured):
    """Half of them compile for floats first, half for whole numbers; each then loads or makes the other."""
    import time

    path = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    environment = {**os.environ, "PYTHONPATH": path}
    start = time.time() + 4.0
    commands = [[sys.executable, "-c", COLD, str(tmp_path), str(start), str(k % 2)] for k in range(4)]
    running = [subprocess.Popen(c, env=environment, stdout=subprocess.PIPE, text=True) for c in commands]
    found = [process.communicate(timeout=120)[0].split() for process in running]
    measured(f"4 processes, {len(list(tmp_path.iterdir()))} files, values {found}")
    assert found == [["42.0", "42"], ["42", "42.0"]] * 2
    assert len(list(tmp_path.iterdir())) == 2


def test_numba_s_folder_of_the_environment_is_checked_for_its_owner_and_mode(tmp_path):
    """Where another account can write into it, it is gone without; a new one is the user's alone."""
    compiled._cache_folder.cache_clear()
    source = Path(compiled.__file__)
    folder = Path(compiled._cache_folder(source, str(tmp_path / "new")))
    assert folder.parent == tmp_path / "new"
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    folder.chmod(0o777)
    compiled._cache_folder.cache_clear()
    assert compiled._cache_folder(source, str(tmp_path / "new")) == ""
    compiled._cache_folder.cache_clear()


def test_a_process_that_needs_a_kernel_while_another_compiles_it_waits_and_loads_it(tmp_path):
    """The first holds its claim for two seconds, as if it compiled; the second loads what it then keeps."""
    slow = (
        "import time; import numba.core.dispatcher as d; plain = d._FunctionCompiler.compile\n"
        "def late(*a):\n    print('compiles', flush=True); time.sleep(2); return plain(*a)\n"
        "d._FunctionCompiler.compile = late\n"
    )
    script = (
        f"import sys, pathlib; sys.path[:0] = [{str(Path(__file__).parent)!r}]\n"
        f"from test_kernel_cache import value\nprint(value(pathlib.Path({str(tmp_path)!r})))"
    )
    first = subprocess.Popen([sys.executable, "-c", slow + script], stdout=subprocess.PIPE, text=True)
    assert first.stdout.readline() == "compiles\n"
    second = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert first.communicate()[0] == "(42.0, 0)\n"
    assert second.stdout == "(42.0, 1)\n"
    assert len(list(tmp_path.iterdir())) == 1, "no claim is left behind"
