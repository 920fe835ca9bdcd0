"""Kernels that kernels call are compiled once, inside their callers, and compute what numba would."""

import os
import subprocess
import sys

import numpy as np
import pytest

from cabledrive.mechanics import compiled, kernel_parts

numba = pytest.importorskip("numba")
pytestmark = pytest.mark.skipif(not compiled.numba_at_hand(), reason="kernels are not compiled here")

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
    paths = os.pathsep.join([str(cache), *sys.path])
    environment = os.environ | environment | {"PYTHONPATH": paths, "NUMBA_CACHE_DIR": str(cache / "kept")}
    command = [sys.executable, "-c", f"{before}\nfrom kernels_of_a_test import *\n{code}"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def test_a_part_is_compiled_once_for_all_constants_and_again_only_where_python_calls_it(tmp_path):
    printed = run(
        "print(COMPILED.count('power'), end=' '); power(2.0, 3, False); print(COMPILED.count('power'))",
        tmp_path,
    )
    assert printed == ["1", "2"]


def test_a_process_that_loads_the_kernel_computes_the_bits_of_the_one_that_compiled_it(tmp_path, measured):
    first, second = (run("print(result.hex(), COMPILED.count('whole'))", tmp_path) for _ in range(2))
    interpreted = run("print(result.hex())", tmp_path, NUMBA_DISABLE_JIT="1")
    apart = abs(float.fromhex(first[0]) / float.fromhex(interpreted[0]) - 1.0)
    measured(f"compiled and interpreted {apart:.1e} apart")
    assert (first[1], second[1]) == ("1", "0"), "the second process loads the kernel"
    assert first[0] == second[0]
    assert apart < 1e-14


def test_a_function_of_a_user_inside_a_kernel_stays_one_that_python_can_call(tmp_path):
    assert float(run("print(of_a_user(2.0))", tmp_path)[0]) == 6.1


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


def test_options_of_kernels_hash_and_compare_as_numba_has_them():
    from numba.core.compiler import Flags

    plain, same, other = Flags(), Flags(), Flags()
    other.nrt = not other.nrt
    assert hash(plain) == hash(tuple(sorted(plain.values()))) == hash(other)
    assert plain == same
    assert plain != other
    assert np.isfinite(hash(plain))
