"""Kernels on disk: a damaged file is made again, a full disk does no harm, nobody else's file is loaded."""

import errno
import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from cabledrive.mechanics import compiled, kernel_parts
from command import python

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
    here = Path(__file__).parent
    script = (
        f"import sys, pathlib; sys.path[:0] = [{str(here)!r}, {str(here.parent)!r}]\n"
        f"from test_kernel_cache import value\nprint(value(pathlib.Path({str(tmp_path)!r})))"
    )
    first = subprocess.Popen([sys.executable, "-c", slow + script], stdout=subprocess.PIPE, text=True)
    assert first.stdout.readline() == "compiles\n"
    second = python(script)
    assert first.communicate()[0] == "(42.0, 0)\n"
    assert second == "(42.0, 1)\n"
    assert len(list(tmp_path.iterdir())) == 1, "no claim is left behind"


# --- Kernels that kernels call are compiled once, inside their callers, and compute what numba would
KERNELS = """
import sys
from math import tanh
import numba
import numpy as np
from numba.core import event
from cabledrive.mechanics.compiled import njit_in_place

COMPILED = []

class Listener(event.Listener):
    def on_start(self, event):
        COMPILED.append(event.data["dispatcher"].py_func.__name__)

    def on_end(self, event):
        pass

event.register("numba:compile", Listener())

@njit_in_place
def power(x, exponent, smooth):
    value = 1.0
    for _ in range(exponent):
        value *= x
    if value > 1e6:
        raise ValueError("too large")
    return tanh(value) if smooth else value

@numba.njit
def of_a_user(x):
    return 3.0 * x + 0.1

@njit_in_place
def whole(x):
    total = 0.0
    for i in range(x.size):
        total += power(x[i], 2, True) + power(x[i], 3, False) + power(x[i], 5, True) + of_a_user(x[i])
    return total

x = np.linspace(-1.3, 1.7, 41)
result = whole(x)
"""


def run(code, cache, before="", **environment):
    """Words that a new process prints after the kernels of this file ran in it."""
    script = cache / "kernels_of_a_test.py"
    script.write_text(KERNELS)
    environment |= {"NUMBA_CACHE_DIR": str(cache / "kept")}
    return python(f"{before}\nfrom kernels_of_a_test import *\n{code}", paths=[cache], **environment).split()


def test_a_process_that_loads_the_kernel_computes_the_bits_of_the_one_that_compiled_it(tmp_path, measured):
    first, second = (run("print(result.hex(), COMPILED.count('whole'))", tmp_path) for _ in range(2))
    interpreted = run("print(result.hex())", tmp_path, NUMBA_DISABLE_JIT="1")
    apart = abs(float.fromhex(first[0]) / float.fromhex(interpreted[0]) - 1.0)
    measured(f"compiled and interpreted {apart:.1e} apart")
    assert (first[1], second[1]) == ("1", "0"), "the second process loads the kernel"
    assert first[0] == second[0]
    assert apart < 1e-14


def test_an_error_inside_a_part_reaches_the_caller(tmp_path):
    code = "try:\n    whole(np.array([3e6]))\nexcept ValueError as error:\n    print(error)"
    assert run(code, tmp_path) == ["too", "large"]
    assert run(code, tmp_path) == ["too", "large"], "loaded"


def test_another_numba_compiles_every_kernel_whole_with_equal_results(tmp_path):
    shown = "from cabledrive.mechanics.kernel_parts import why_whole\n"
    shown += "print(result.hex(), COMPILED.count('power'), why_whole())"
    parts = run(shown, tmp_path)
    (tmp_path / "other").mkdir()
    other = run(shown, tmp_path / "other", before="import numba; numba.__version__ = '0.999.0'")
    assert parts[1:] == ["1", "None"]
    assert float.fromhex(other[0]) == pytest.approx(float.fromhex(parts[0]), rel=1e-14)
    assert int(other[1]) == 3, "a version for each constant exponent"
    assert {"0.999.0", *(f"({one}):" for one in kernel_parts.TRIED)} <= set(other)


def test_the_numba_of_the_constraints_has_the_inside_that_parts_use():
    """If this fails, numba has moved what `kernel_parts.INSIDE` names.

    Kernels still compile, as numba does it by itself, in twice the time. Read the new versions of the names
    in numba's sources, mend `kernel_parts`, run this file and `make bench`, put the version into `TRIED`.
    """
    assert kernel_parts.why_whole() is None
