"""The translator: what it takes, what it refuses, and that Python and C change together."""

import ctypes

import numpy as np
import pytest

from cabledrive.export.blocks import controller_block
from cabledrive.export.translation.nodes import BOOL, INT, REAL, Scalar, View
from cabledrive.export.translation.program import Program
from cabledrive.rig.laws.registry import CONTROLLERS, OPEN_LOOPS
from command import refused
from export.designs import WARNINGS, built, source_of

VECTOR = View(REAL, (4,))


def with_power(x: float) -> float:
    return x**2.5


def with_list(x: float) -> float:
    values = [x, x]
    return values[0]


def with_recursion(x: float) -> float:
    return with_recursion(x)


def with_two_types(x: float, v: np.ndarray) -> float:
    y = x
    y = v
    return y


def beyond_the_end(v: np.ndarray) -> float:
    return v[4]


def after_its_loop(v: np.ndarray) -> float:
    for i in range(4):
        v[i] = 0.0
    return v[i]


def without_result(x: float) -> float:
    if x > 0.0:
        return x


def with_two_results(x: float) -> float:
    if x > 0.0:
        return x
    return x > 1.0


def floor_of_unknown(n: int) -> int:
    return n // 2


def impure_inside(v: np.ndarray) -> float:
    return 1.0 + writes(v)


def writes(v: np.ndarray) -> float:
    v[0] = 1.0
    return 2.0


def with_print(x: float) -> float:
    print(x)
    return x


@pytest.mark.parametrize(
    "function, kinds, named",
    [
        (with_power, [Scalar(REAL)], "arithmetic"),
        (with_list, [Scalar(REAL)], "List"),
        (with_two_types, [Scalar(REAL), VECTOR], "two types"),
        (beyond_the_end, [VECTOR], "element 4 of 4"),
        (after_its_loop, [VECTOR], "after its loop"),
        (without_result, [Scalar(REAL)], "without a result"),
        (with_two_results, [Scalar(REAL)], "another type than before"),
        (floor_of_unknown, [Scalar(INT)], "//"),
        (impure_inside, [VECTOR], "changes something"),
        (with_print, [Scalar(REAL)], "print"),
    ],
)
def test_what_lies_outside_the_subset_is_refused_at_file_and_line(function, kinds, named):
    words = refused(lambda: Program().translate(function, list(kinds)))
    assert words.startswith("test_translation.py:")
    assert int(words.split(":")[1]) >= function.__code__.co_firstlineno
    assert named in words or named == "arithmetic"
    assert "CONTRIBUTING" in words


def test_a_recursion_is_refused():
    refused(lambda: Program().translate(with_recursion, [Scalar(REAL)]), "recursion")


@pytest.mark.parametrize("name", [name for name in CONTROLLERS if name not in OPEN_LOOPS])
def test_the_kernels_of_every_law_stay_inside_the_subset_and_are_c(name, tmp_path):
    source = source_of(name)
    made = controller_block(source)
    assert made.words["step"].result.items == (Scalar(REAL), Scalar(BOOL))
    assert made.words["row_call"]
    for file, text in made.code().items():
        (tmp_path / file).write_text(text)
    done = built(tmp_path, "-fsyntax-only", *WARNINGS)
    assert done.returncode == 0, done.stderr


def arithmetic(v: np.ndarray, n: int) -> float:
    a, b = v[0], v[1]
    a, b = b, a
    total, count = 0.0, 0
    for i in range(3, -1, -1):
        if i % 2 == 1 and not v[i] < 0.0:
            continue
        count += n
        total += (v[i] if i > 1 else -v[i]) / (i + 1)
    while total > 1.0:
        total *= 0.5
    return max(min(total, v[2], a), b - count) + min(n, 3) * abs(v[3]) + int(v[2]) + count / 7


@pytest.mark.parametrize("seed", range(3))
def test_arithmetic_of_the_subset_is_that_of_python_to_the_bit(seed, tmp_path):
    program = Program()
    made = program.translate(arithmetic, [VECTOR, Scalar(INT)])
    head = "#include <math.h>\n#include <stdint.h>\n#include <stdbool.h>\ntypedef double real;\n"
    for name, kind, sign in ("cd_min", "real", "<"), ("cd_max", "real", ">"), ("cd_imin", "int32_t", "<"):
        head += f"static {kind} {name}({kind} a, {kind} b) {{ return b {sign} a ? b : a; }}\n"
    shell = f"double run(const double *v, int32_t n) {{ return {made.name}(v, n); }}\n"
    (tmp_path / "one.c").write_text(head + program.functions() + shell)
    assert built(tmp_path, "-O2", "-shared", "-fPIC", name="one.so").returncode == 0
    run = ctypes.CDLL(str(tmp_path / "one.so")).run
    run.restype = ctypes.c_double
    generator = np.random.default_rng(seed)
    for _ in range(100):
        values, n = generator.standard_normal(4) * 3.0, int(generator.integers(0, 9))
        assert run((ctypes.c_double * 4)(*values), n) == arithmetic(values, n)
