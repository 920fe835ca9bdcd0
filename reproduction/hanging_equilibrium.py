"""Where a hanging mass rests: as printed, and with the stretch of the cable it pulls down."""

from dataclasses import dataclass

import numpy as np

from cabledrive.modal.lateral import HangingCarriage, hanging_carriage
from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.parameters.arrays import Array

MOST_STEPS = 100
_SHORTEST = 2.0**-40


@dataclass(frozen=True, slots=True, kw_only=True)
class HangingEquilibrium:
    """Rest of a hanging mass on a cable without weight, and the forces there.

    Attributes
    ----------
    sag : float
        Distance H of the mass from the straight cable [m].
    shift : float
        Its displacement along the span, in the span's direction [m].
    tension_before, tension_after : float
        Tension of the cable on its two sides [N].
    sine_before, sine_after : float
        Sines of the sag angles theta_1e and theta_2e [-].
    residual : float
        Largest force left out of balance [N].
    """

    sag: float
    shift: float
    tension_before: float
    tension_after: float
    sine_before: float
    sine_after: float
    residual: float


def linear_equilibrium(drive: Drive, carriage: int = 0) -> HangingEquilibrium:
    r"""Rest of a hanging mass while the tension stays T0, Eqs. (3.29), (3.30).

    .. math:: T_0\sin\theta_{1e} + T_0\sin\theta_{2e} = m g, \qquad \sin\theta_{ie} = H/L_i

    On a slope :math:`\varphi` the part :math:`g\cos\varphi` across the cable takes the place of g. The print
    does not say that the weight of the cable is left out.

    Parameters
    ----------
    drive : Drive
    carriage : int, default 0
        Number of the carriage in the file.

    Returns
    -------
    HangingEquilibrium

    Raises
    ------
    InputRefused
        If the carriage is guided, or hangs beside another.
    NotComputed
        If the sag is so deep that a sine would exceed 1.
    """
    hanging = hanging_carriage(drive, carriage)
    sag = hanging.mass * drive.layout.gravity_across / hanging.lateral_stiffness
    shorter = min(hanging.before, hanging.after)
    if sag >= shorter:
        raise NotComputed(
            f"linear sag of {sag:.4g} m reaches the distance of {shorter:.4g} m to the nearest support: "
            "use elastic_equilibrium, or raise cable.pretension"
        )
    return HangingEquilibrium(
        sag=sag,
        shift=0.0,
        tension_before=hanging.tension,
        tension_after=hanging.tension,
        sine_before=sag / hanging.before,
        sine_after=sag / hanging.after,
        residual=0.0,
    )


def elastic_equilibrium(drive: Drive, carriage: int = 0, *, hold: str = "drive") -> HangingEquilibrium:
    r"""Rest of a hanging mass with exact geometry and the stretch of the cable, Eq. (M.9).

    Least of the energy of straight pieces of cable,

    .. math:: V = \sum_i \tfrac12 \frac{EA}{l_i}(\ell_i - l_i)^2 - m g H\cos\varphi \pm m g x\sin\varphi,

    over sag H, shift x and the turning of the load pulley, by Newton's method with line search; V is convex
    while the cable is taut. A free load pulley lets the other span give way.

    Parameters
    ----------
    drive : Drive
        With this carriage alone.
    carriage : int, default 0
        Number of the carriage in the file.
    hold : {"drive", "both"}, default "drive"
        Pulleys that are held. Of a line both always are.

    Returns
    -------
    HangingEquilibrium

    Raises
    ------
    InputRefused
        If the carriage is guided, there are others, or `hold` is not one of its values.
    NotComputed
        If the cable goes slack beside the mass, or no equilibrium is found.
    """
    hanging = hanging_carriage(drive, carriage)
    if hold not in ("drive", "both"):
        raise InputRefused(f'hold = "{hold}" is not one of its values: write "drive" or "both"')
    if len(drive.carriage) > 1:
        raise InputRefused(
            f"carriage: {len(drive.carriage)} given, but this equilibrium is of one: take the others out"
        )
    pieces = _Pieces(drive, hanging, held=hold == "both" or drive.kind == "line" or drive.load_pulley.fixed)
    place, residual = _least_energy(pieces)
    tension, sine = pieces.tensions(place), pieces.sines(place)
    if min(tension[:2]) <= 0.0:
        raise NotComputed(
            f"the cable is slack beside carriage {carriage} of {hanging.mass:.4g} kg: raise cable.pretension"
        )
    return HangingEquilibrium(
        sag=float(place[1]),
        shift=float(place[0]),
        tension_before=float(tension[0]),
        tension_after=float(tension[1]),
        sine_before=float(sine[0]),
        sine_after=float(sine[1]),
        residual=residual,
    )


class _Pieces:
    """Cable before and after the mass, and the other span; unknowns: shift, sag, run of the load rim.

    As everywhere in this package, the end of a span moves along the span as its rim does, u(Le) = r2 theta2.
    """

    def __init__(self, drive: Drive, hanging: HangingCarriage, *, held: bool) -> None:
        upper = hanging.span == "upper"
        self.unknowns = 2 if held else 3
        self.chords = np.array([hanging.before, hanging.after, drive.pulley_distance])
        self.lengths = self.chords / (1.0 + drive.cable.prestrain)
        self.stiffness = drive.cable.axial_rigidity / self.lengths
        run = (0.0, 1.0, -1.0) if upper else (-1.0, 0.0, 1.0)
        self.along = np.array([[1.0, 0.0, run[0]], [-1.0, 0.0, run[1]], [0.0, 0.0, run[2]]])
        self.across = np.array([[0.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
        weight = hanging.mass * drive.layout.gravity
        along, across = hanging.mass * drive.layout.gravity_along, hanging.mass * drive.layout.gravity_across
        self.load = np.array([-along if upper else along, across, 0.0])
        self.tolerance = 1e-12 * max(hanging.tension, weight) + 1e-14 * drive.cable.axial_rigidity

    def _geometry(self, place: Array) -> tuple[Array, Array, Array]:
        """Lengths of the three pieces, and the cosines and sines of their slopes."""
        along, across = self.chords + self.along @ place, self.across @ place
        length = np.hypot(along, across)
        return length, along / length, across / length

    def tensions(self, place: Array) -> Array:
        return self.stiffness * np.maximum(self._geometry(place)[0] - self.lengths, 0.0)

    def sines(self, place: Array) -> Array:
        return self._geometry(place)[2]

    def energy(self, place: Array) -> float:
        stretch = np.maximum(self._geometry(place)[0] - self.lengths, 0.0)
        return float(0.5 * self.stiffness @ stretch**2 - self.load @ place)

    def unbalanced(self, place: Array) -> Array:
        """Forces left over on the unknowns."""
        _, cosine, sine = self._geometry(place)
        pull = self.tensions(place)
        return (self.load - (pull * cosine) @ self.along - (pull * sine) @ self.across)[: self.unknowns]

    def stiffness_matrix(self, place: Array) -> Array:
        """Second derivatives of the energy on the unknowns: stretch of the pieces, and their turning."""
        length, cosine, sine = (row[:, None] for row in self._geometry(place))
        stretch = cosine * self.along + sine * self.across
        turn = cosine * self.across - sine * self.along
        geometric = self.tensions(place)[:, None] / length
        matrix = stretch.T @ (self.stiffness[:, None] * stretch) + turn.T @ (geometric * turn)
        return matrix[: self.unknowns, : self.unknowns]


def _least_energy(pieces: _Pieces) -> tuple[Array, float]:
    """Newton's method from the straight cable; a step is halved until energy or forces left are lower."""
    place = np.zeros(3)
    for _ in range(MOST_STEPS):
        left = pieces.unbalanced(place)
        if np.abs(left).max() <= pieces.tolerance:
            return place, float(np.abs(left).max())
        step = np.zeros(3)
        step[: pieces.unknowns] = np.linalg.solve(pieces.stiffness_matrix(place), left)
        place = _line_search(pieces, place, step)
    raise NotComputed(
        f"no equilibrium of the hanging mass within {MOST_STEPS} Newton steps: "
        f"{np.abs(left).max():.3g} N out of balance; raise cable.pretension"
    )


def _line_search(pieces: _Pieces, place: Array, step: Array) -> Array:
    energy, left = pieces.energy(place), np.abs(pieces.unbalanced(place)).max()
    gain = float(pieces.unbalanced(place) @ step[: pieces.unknowns])
    share = 1.0
    while share > _SHORTEST:
        trial = place + share * step
        if pieces.energy(trial) <= energy - 1e-4 * share * gain:
            return trial
        if np.abs(pieces.unbalanced(trial)).max() <= (1.0 - 1e-4 * share) * left:
            return trial
        share *= 0.5
    raise NotComputed("no equilibrium of the hanging mass: Newton's step lowers neither energy nor forces")
