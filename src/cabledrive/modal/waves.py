r"""A mode as the waves it is made of, piece by piece: what exact integrals over mode shapes need.

On a piece of cable of length l between displacements :math:`u_a, u_b` the exact solution (3.11) has the slope

.. math:: \frac{\mathrm{d}u}{\mathrm{d}s} = \operatorname{Re}\,S e^{iks}, \qquad
          S = k\Big(\frac{u_b - u_a\cos kl}{\sin kl} + i u_a\Big). \qquad \text{Eq. (A.3)}
"""

from dataclasses import dataclass
from math import atan2, ceil, cos, pi, sin

from cabledrive.mechanics.labelled_chain import LabelledChain
from cabledrive.modal.solver import ChainMode


@dataclass(frozen=True, slots=True, kw_only=True)
class Wave:
    """The slope of a mode on one piece of cable.

    Attributes
    ----------
    span : {"upper", "lower"}
    start, length : float
        Unstretched position from the pulley where the span starts, and length [m].
    wave_number : float
        k [rad/m], unstretched metres.
    slope : complex
        S of Eq. (A.3).
    """

    span: str
    start: float
    length: float
    wave_number: float
    slope: complex

    def slope_at(self, position: float) -> complex:
        """Complex slope with its phase at another position of the piece.

        ``position``: unstretched position [m].
        """
        phase = self.wave_number * (position - self.start)
        return self.slope * complex(cos(phase), sin(phase))

    @property
    def largest_displacement(self) -> float:
        """Largest displacement on the piece."""
        amplitude, first = (
            abs(self.slope) / self.wave_number,
            atan2(self.slope.imag, self.slope.real) - pi / 2,
        )
        last = first + self.wave_number * self.length
        if ceil(first / pi) * pi <= last:
            return amplitude
        return amplitude * max(abs(cos(first)), abs(cos(last)))


def waves(chain: LabelledChain, solved: ChainMode, shape: int = 0) -> tuple[Wave, ...]:
    """Pieces of one shape of a mode, in the order of the chain, Eq. (A.3).

    ``shape``: which of the shapes, where the mode is multiple.
    Returns of unit modal mass.
    """
    split, places, u = solved.split, solved.joints, solved.shapes[:, shape]
    pieces, joints = split.lengths.size, split.masses.size
    k = solved.omega / split.wave_speed
    found = []
    for number, stretch in enumerate(chain.stretches):
        position = stretch.start
        end = places[number + 1] if number + 1 < places.size else pieces
        for piece in range(places[number], end):
            length = float(split.lengths[piece])
            near, far = float(u[piece]), float(u[(piece + 1) % joints])
            slope = k * complex((far - near * cos(k * length)) / sin(k * length), near)
            found.append(Wave(span=stretch.span, start=position, length=length, wave_number=k, slope=slope))
            position += length
    return tuple(found)
