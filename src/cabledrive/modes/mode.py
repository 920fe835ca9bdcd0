"""A natural mode of a drive: frequency, kind, family, and its shape on every span and joint."""

from dataclasses import dataclass, field
from math import pi

import numpy as np

from cabledrive.mechanics.chain import Array
from cabledrive.mechanics.spans import DRIVE_PULLEY, LOAD_PULLEY, MOTOR, LabelledChain
from cabledrive.modes.solver import ChainMode

LONGITUDINAL, TRANSVERSE = "longitudinal", "transverse"
_AT_REST = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False)
class Mode:
    """One natural frequency, with as many shapes as its multiplicity.

    Attributes
    ----------
    frequency : float
        Natural frequency [Hz].
    kind : {"longitudinal", "transverse"}
    family : str
        What mainly moves; see `family_of`.
    multiplicity : int
        Number of independent shapes at this frequency.
    span : str or None
        Transverse modes: the span that vibrates, "upper" or "lower".
    plane : str or None
        Transverse modes: "v" (horizontal) or "w" (the plane of the loop).
    section : (float, float) or None
        Transverse modes: unstretched ends of the vibrating section [m], from the pulley where its span starts.
    kinetic_shares : dict of str to float
        Share of the kinetic energy in each joint that carries a mass and in the "cable"; mean over the shapes.
    proven : bool
        Whether counts just below and just above prove that it exists, with this multiplicity.
    """

    frequency: float
    kind: str
    family: str
    multiplicity: int
    span: str | None = None
    plane: str | None = None
    section: tuple[float, float] | None = None
    kinetic_shares: dict[str, float]
    proven: bool
    _chain: LabelledChain = field(repr=False)
    _solved: ChainMode = field(repr=False)

    @property
    def joints(self) -> dict[str, Array]:
        """Displacement of every joint, shape (multiplicity,) each, of unit modal mass [kg^-1/2]; rims: r theta."""
        return _joint_shapes(self._chain, self._solved)

    def shape(self, span: str, positions: Array) -> Array:
        r"""Displacement along a span, from the exact solution between the joints.

        .. math:: u(s) = \frac{u_a \sin k(l - s) + u_b \sin ks}{\sin kl} \qquad \text{Eq. (3.11)}

        Parameters
        ----------
        span : {"upper", "lower"}
        positions : array_like, shape (p,)
            Unstretched positions from the pulley where the span starts [m].

        Returns
        -------
        ndarray, shape (multiplicity, p)
            Displacements of unit modal mass [kg^-1/2]; zero where this mode does not reach.
        """
        positions = np.asarray(positions, dtype=float)
        split, shapes = self._solved.split, self._solved.shapes
        out = np.zeros((self.multiplicity, positions.size))
        wave_number = 2 * pi * self.frequency / split.wave_speed
        for piece, (start, length) in self._pieces(span):
            here = (positions >= start) & (positions <= start + length)
            s = positions[here] - start
            near, far = shapes[piece], shapes[(piece + 1) % split.masses.size]
            bend = np.sin(wave_number * np.stack((length - s, s)))
            out[:, here] = (np.outer(near, bend[0]) + np.outer(far, bend[1])) / np.sin(wave_number * length)
        return out

    def _pieces(self, span: str) -> list[tuple[int, tuple[float, float]]]:
        """Pieces of the split chain that lie on a span: number, unstretched start and length."""
        lengths, joints = self._solved.split.lengths, self._solved.joints
        pieces = []
        for number, stretch in enumerate(self._chain.stretches):
            position = stretch.start
            last = joints[number + 1] if number + 1 < joints.size else lengths.size
            for piece in range(joints[number], last):
                if stretch.span == span:
                    pieces.append((piece, (position, float(lengths[piece]))))
                position += float(lengths[piece])
        return pieces


def make_mode(chain: LabelledChain, solved: ChainMode, kind: str, plane: str | None = None) -> Mode:
    """Name a mode of a chain in the terms of the machine.

    Parameters
    ----------
    chain : LabelledChain
    solved : ChainMode
    kind : {"longitudinal", "transverse"}
    plane : str, optional
        Of a transverse mode.

    Returns
    -------
    Mode
    """
    shares = _kinetic_shares(chain, solved)
    where = chain.stretches if kind == TRANSVERSE else ()
    return Mode(
        frequency=solved.omega / (2 * pi),
        kind=kind,
        family=family_of(chain, solved, shares, kind),
        multiplicity=solved.multiplicity,
        span=where[0].span if where else None,
        plane=plane,
        section=(where[0].start, where[-1].end) if where else None,
        kinetic_shares=shares,
        proven=solved.proven,
        _chain=chain,
        _solved=solved,
    )


def _joint_shapes(chain: LabelledChain, solved: ChainMode) -> dict[str, Array]:
    rows = [*solved.joints, solved.split.masses.size][: len(chain.joints)]
    return {name: solved.shapes[row] for name, row in zip(chain.joints, rows, strict=True)}


def _kinetic_shares(chain: LabelledChain, solved: ChainMode) -> dict[str, float]:
    """Shares of the kinetic energy; the shapes have unit modal mass, so what the masses lack is the cable's."""
    masses = [*chain.chain.masses, chain.chain.pendant[1] if chain.chain.pendant else 0.0]
    shapes = _joint_shapes(chain, solved)
    shares = {
        name: float(mass * np.mean(shapes[name] ** 2))
        for name, mass in zip(chain.joints, masses, strict=False)
        if np.any(shapes[name])
    }
    return shares | {"cable": 1.0 - sum(shares.values())}


def family_of(chain: LabelledChain, solved: ChainMode, shares: dict[str, float], kind: str) -> str:
    """What mainly moves in a mode.

    Parameters
    ----------
    chain : LabelledChain
    solved : ChainMode
    shares : dict of str to float
        Shares of the kinetic energy.
    kind : {"longitudinal", "transverse"}

    Returns
    -------
    str
        "carriage-dominated" if carriages hold half of the kinetic energy or more; else, of a transverse mode, "string";
        "motor joint" if the joint holds half of the strain energy; else, by the motion of the two rims,
        "pulleys out of phase", "pulleys in phase", "pulleys at rest", "drive pulley turning" or
        "load pulley turning" (the other at rest), or "pulleys independent" (a multiple mode that has both).
    """
    if sum(share for name, share in shares.items() if name.startswith("carriage")) >= 0.5:
        return "carriage-dominated"
    if kind == TRANSVERSE:
        return "string"
    shapes = _joint_shapes(chain, solved)
    if MOTOR in shapes and chain.chain.pendant is not None:
        twist = shapes[MOTOR] - shapes[DRIVE_PULLEY]
        if chain.chain.pendant[0] * np.mean(twist**2) >= 0.5 * solved.omega**2:
            return "motor joint"
    return _pulley_family(shapes, chain)


def _pulley_family(shapes: dict[str, Array], chain: LabelledChain) -> str:
    mass = chain.chain.masses.sum() + chain.chain.density * chain.chain.lengths.sum()
    nothing = np.zeros(1)
    drive, load = shapes.get(DRIVE_PULLEY, nothing), shapes.get(LOAD_PULLEY, nothing)
    turning = [name for name, u in ((DRIVE_PULLEY, drive), (LOAD_PULLEY, load)) if np.sum(u**2) * mass > _AT_REST**2]
    if not turning:
        return "pulleys at rest"
    if len(turning) == 1:
        return f"{turning[0]} turning"
    product, size = np.sum(drive * load), np.sqrt(np.sum(drive**2) * np.sum(load**2))
    if abs(product) < 0.5 * size:
        return "pulleys independent"
    return "pulleys in phase" if product > 0 else "pulleys out of phase"
