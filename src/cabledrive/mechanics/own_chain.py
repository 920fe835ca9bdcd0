"""A chain that is built in Python: looked over, and its parts named."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cabledrive.mechanics.chain import Chain
from cabledrive.mechanics.labelled_chain import LabelledChain, Stretch
from cabledrive.parameters.errors import InputRefused


def own_chain(chain: Chain) -> LabelledChain:
    """A chain with joints "joint 0" and on, "pendant 0" and on, and spans "segment 0" and on, checked."""
    chain = _in_arrays(chain)
    _check(chain)
    pendants = tuple(f"pendant {i}" for i in range(len(chain.pendants)))
    return LabelledChain(
        chain=chain,
        joints=tuple(f"joint {i}" for i in range(chain.masses.size)) + pendants,
        stretches=tuple(
            Stretch(span=f"segment {i}", start=0.0, end=float(length))
            for i, length in enumerate(chain.lengths)
        ),
        pendant_springs=tuple(f"spring of {name}" for name in pendants),
        ground="spring to the ground" if chain.sprung else "",
    )


def _in_arrays(chain: Chain) -> Chain:
    """The chain with arrays of floats where lists of numbers were given."""
    given: dict[str, Any] = {}
    for name in ("rigidity", "density", "lengths", "masses", "grounds"):
        value = getattr(chain, name)
        given[name] = value if np.ndim(value) == 0 else np.asarray(value, dtype=float)
    return replace(chain, pendants=tuple(chain.pendants), **given)


def _check(chain: Chain) -> None:
    """Refuse what is not positive, not finite, or not there once for each segment or joint."""
    for place, name, unit, values, zero in _quantities(chain):
        array = np.asarray(values, dtype=float)
        parts = chain.masses.size if place == "joint" else chain.lengths.size
        if array.shape not in ((), (parts,)):
            raise InputRefused(
                f"{name} has {array.size} values for {parts} {place}s: give one value, or one for each"
            )
        fine = np.isfinite(array) & ((array >= 0.0) if zero else (array > 0.0))
        if not fine.all():
            number = int(np.argmin(fine))
            where = f"{place} {number}" if array.ndim else place
            bound = "must not be negative" if zero else "must be positive"
            raise InputRefused(
                f"{where}: {name} = {np.ravel(array)[number]:.6g} {unit} {bound} and finite: correct it"
            )
    for number, pendant in enumerate(chain.pendants):
        if not 0 <= pendant.joint < chain.masses.size:
            raise InputRefused(
                f"pendant {number}: joint = {pendant.joint} must be one of 0 to {chain.masses.size - 1}"
            )


def _quantities(chain: Chain) -> Iterator[tuple[str, str, str, ArrayLike, bool]]:
    """Place, name, unit and values of every quantity, and whether it may be zero."""
    yield "segment", "rigidity", "N", chain.rigidity, False
    yield "segment", "density", "kg/m", chain.density, False
    yield "segment", "length", "m", chain.lengths, False
    yield "joint", "mass", "kg", chain.masses, True
    yield "joint", "grounds", "N/m", chain.ground_springs, True
    for number, pendant in enumerate(chain.pendants):
        place = f"pendant {number}"
        yield place, "stiffness", "N/m", pendant.stiffness, False
        yield place, "mass", "kg", pendant.mass, False
        yield place, "ground", "N/m", pendant.ground, True
