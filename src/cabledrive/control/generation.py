"""Writes the backstepping laws as code: a compiled step and a readable twin of each.

Run ``python -m cabledrive.control.generation`` after a change; it needs SymPy and rewrites the files beside
it. Their text depends on nothing else, and a test holds them against it.
"""

from collections.abc import Iterator
from pathlib import Path
from textwrap import wrap
from typing import Any

from cabledrive.control.backstepping_symbols import Backstepping

WIDTH = 100
NAMES = {2: "four", 3: "six"}


def assignment(name: str, value: Any) -> Iterator[str]:
    """Lines of code that give an expression a name.

    Parameters
    ----------
    name : str
    value : Expr

    Yields
    ------
    str
    """
    import sympy as sp

    text = sp.pycode(sp.sympify(value))
    if len(text) < WIDTH - 10:
        yield f"    {name} = {text}"
        return
    yield f"    {name} = ("
    yield from (f"        {line}" for line in wrap(text, WIDTH - 8, break_long_words=False))
    yield "    )"


def source_of(law: Backstepping) -> str:
    """The text of a law's module.

    Parameters
    ----------
    law : Backstepping

    Returns
    -------
    str
    """
    n, word = law.inertias, NAMES[law.inertias]
    lines = [line for name, value in law.steps() for line in assignment(name, value)]
    tau = [line for name, value in law.adaptation() for line in assignment(name, value)]
    phi = [line for name, value in law.regressors() for line in assignment(name, value)]
    scaled = [f"    x1, x2 = states[{n - 1}], states[{2 * n - 1}]"]
    for j in range(1, n):
        for place, x in ((n - j, 2 * j + 1), (2 * n - j, 2 * j + 2)):
            scaled.append(f"    x{x} = s{j} * (states[{place - 1}] - states[{place}])")
    signals = [f"    {signal} = reference[k, {m}]" for m, signal in enumerate(law.time)]
    slots = [*map(str, law.gains.values()), *map(str, law.scales)]
    constants = [f"    {name} = gains[0, {m}]" for m, name in enumerate(slots)]
    estimates = [f"    {p} = estimate[{m}]" for m, p in enumerate(law.p)]
    friction = [
        f"    speed = states[{n}]",
        f"    friction = tanh(scalars[2] * (reference[k, {len(law.time)}] if scalars[3] > 0.0 else speed))",
    ]
    values = [
        f"    {', '.join(map(str, names))}, = {given}"
        for names, given in ((slots, "gains"), (law.p, "estimate"), (law.x, "x"), (law.time, "signals"))
    ]
    listed = [
        f"    return u, ({', '.join(f'z{i}' for i in range(1, 2 * n + 1))}), ("
        f"{', '.join(f'alpha{i}' for i in range(1, 2 * n))}), phi"
    ]
    return "\n".join(
        [
            HEAD.format(n=n, pairs=", ".join(f"({i}, {j})" for i, j in law.gains)),
            KERNEL.format(word=word),
            *constants,
            *estimates,
            *scaled,
            *friction,
            *signals,
            *lines,
            *tau,
            "    return u, z1",
            "",
            "",
            READABLE.format(word=word),
            *values,
            *lines,
            f"    phi = [[0.0] * {len(law.p)} for _ in range({2 * n})]",
            *phi,
            *listed,
            "",
        ]
    )


HEAD = '''"""Backstepping on {n} inertias, written by `cabledrive.control.generation`; change it there."""
# fmt: off

from math import tanh
from typing import Any

from cabledrive.control.numbers import Array
from cabledrive.mechanics.compiled import njit

# Step and error of each gain.
GAINS = ({pairs})

'''

KERNEL = '''@njit
def backstepping_{word}(
    gains: Array, scalars: Array, estimate: Array, states: Array, reference: Array, k: int, tau: Array
) -> tuple[float, float]:
    """Command and first error; writes the adaptation function tau."""'''

READABLE = '''def backstepping_{word}_reference(
    gains: Any, estimate: Any, x: Any, signals: Any, speed: Any, friction: Any
) -> tuple[Any, tuple[Any, ...], tuple[Any, ...], list[list[Any]]]:
    """Command, errors z, virtual controls alpha, regressors phi, from scaled states; any numbers."""'''

LAWS = {
    "backstepping_four": Backstepping(2, known=False, printed=True),
    "backstepping_six": Backstepping(3, known=True, printed=False),
}


def write() -> None:
    """Write every law's module beside this one."""
    for name, law in LAWS.items():
        Path(__file__).with_name(f"{name}.py").write_text(source_of(law), encoding="utf-8")


if __name__ == "__main__":
    write()
