"""Shapes of the modes of a chain: on every span and joint, and what mainly moves in them."""

from dataclasses import dataclass

import numpy as np

from cabledrive.mechanics.chain import Array
from cabledrive.mechanics.holding import DRIVE_PULLEY, LOAD_PULLEY
from cabledrive.mechanics.labelled_chain import LabelledChain
from cabledrive.modal.solver import ChainMode

LONGITUDINAL, TRANSVERSE = "longitudinal", "transverse"
_AT_REST = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class ChainMotion:
    """Shapes of a mode of a chain.

    Attributes
    ----------
    chain : LabelledChain
    solved : ChainMode
    """

    chain: LabelledChain
    solved: ChainMode

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, in order."""
        return self.chain.joints

    def family(self, kind: str) -> str:
        """What mainly moves."""
        return family_of(self.chain, self.solved, kind)

    @property
    def kinetic_shares(self) -> dict[str, float]:
        """Share of the kinetic energy in each joint that moves and in the "cable"; mean over the shapes."""
        shares = _joint_shares(self.chain, self.solved)
        named = {name: float(share) for name, share in zip(self.chain.joints, shares, strict=True) if share}
        return named | {"cable": float(1.0 - shares.sum())}

    @property
    def joints(self) -> dict[str, Array]:
        """Displacement of each joint, shape (multiplicity,), of unit modal mass [kg^-1/2]; rims: r theta."""
        return dict(zip(self.chain.joints, _joint_shapes(self.chain, self.solved), strict=True))

    def shape(self, span: str, positions: Array) -> Array:
        r"""Displacement along a span, from the exact solution between the joints.

        .. math:: u(s) = \frac{u_a \sin k(l - s) + u_b \sin ks}{\sin kl}

        which is Eqs. (3.11), (3.18), (3.24), (3.28) with the displacements of both ends for constants.

        ``span``, {"upper", "lower"}; ``positions``, shape (p,): unstretched positions from the pulley where
        the span starts [m].
        Returns shape (multiplicity, p): displacements of unit modal mass [kg^-1/2]; zero where this mode does
        not reach.
        """
        split, shapes = self.solved.split, self.solved.shapes
        out = np.zeros((self.solved.multiplicity, positions.size))
        wave_numbers = self.solved.omega / split.wave_speeds
        for piece, (start, end) in self._pieces(span):
            wave_number = wave_numbers[piece]
            here = (positions >= start) & (positions <= end)
            s, length = positions[here] - start, end - start
            near, far = shapes[piece], shapes[(piece + 1) % split.masses.size]
            bend = np.sin(wave_number * np.stack((length - s, s)))
            out[:, here] = (np.outer(near, bend[0]) + np.outer(far, bend[1])) / np.sin(wave_number * length)
        return out

    def slopes_at(self, joint: str) -> tuple[Array, Array]:
        """Slope of the displacement just before and just after a joint, along the span's direction.

        ``joint``: a name among `joints`, but the motor's: "carriage 0".
        Returns ``before, after``, shape (multiplicity,): derivatives by the unstretched position [kg^-1/2 /
        m]; zero beyond the end of an open chain.
        """
        split, shapes = self.solved.split, self.solved.shapes
        here = int(self.solved.joints[self.chain.joints.index(joint)])
        wave_numbers = self.solved.omega / split.wave_speeds
        slopes = []
        for piece, end in ((here - 1, 1), (here, 0)):
            if not split.closed and not 0 <= piece < split.lengths.size:
                slopes.append(np.zeros(self.solved.multiplicity))
                continue
            wave_number = wave_numbers[piece]
            phase = wave_number * float(split.lengths[piece])
            near, far = shapes[piece % split.masses.size], shapes[(piece + 1) % split.masses.size]
            turned = far * np.cos(phase) - near if end else far - near * np.cos(phase)
            slopes.append(wave_number * turned / np.sin(phase))
        return slopes[0], slopes[1]

    def _pieces(self, span: str) -> list[tuple[int, tuple[float, float]]]:
        """Pieces of the split chain that lie on a span: number, unstretched start and end, without gaps."""
        lengths, joints = self.solved.split.lengths, self.solved.joints
        pieces = []
        for number, stretch in enumerate(self.chain.stretches):
            position = stretch.start
            last = joints[number + 1] if number + 1 < joints.size else lengths.size
            for piece in range(joints[number], last):
                end = position + float(lengths[piece]) if piece < last - 1 else stretch.end
                if stretch.span == span:
                    pieces.append((piece, (position, end)))
                position = end
        return pieces


def _joint_shapes(chain: LabelledChain, solved: ChainMode) -> Array:
    """Displacements of the joints and pendants, shape (joints, multiplicity)."""
    pendants = solved.split.masses.size + np.arange(len(chain.chain.pendants))
    return solved.shapes[np.append(solved.joints, pendants)]


def _joint_shares(chain: LabelledChain, solved: ChainMode) -> Array:
    """Shares of the joints in the kinetic energy, which is one half omega^2 for shapes of unit modal mass."""
    return chain.chain.all_masses * np.mean(_joint_shapes(chain, solved) ** 2, axis=1)


def family_of(chain: LabelledChain, solved: ChainMode, kind: str) -> str:
    """What mainly moves in a mode.

    ``kind``, {"longitudinal", "transverse"}.
    Returns "carriage-dominated" if carriages hold half of the kinetic energy or more; else, of a transverse
    mode, "string"; of a longitudinal one "motor joint" or "holding stiffness" if that spring holds half of
    the strain energy, else, by the motion of the two rims, "pulleys out of phase", "pulleys in phase",
    "pulleys at rest", "drive pulley turning" or "load pulley turning" (the other at rest), or "pulleys
    independent" (a multiple mode that has both).
    """
    shares = _joint_shares(chain, solved)
    if shares[chain.carriages].sum() >= 0.5:
        return "carriage-dominated"
    if kind == TRANSVERSE:
        return "string"
    shapes = _joint_shapes(chain, solved)
    springs = _spring_shares(chain, shapes, solved.omega)
    spring = max(springs, key=lambda name: springs[name], default="")
    return spring if springs.get(spring, 0.0) >= 0.5 else _pulley_family(chain, shapes)


def _spring_shares(chain: LabelledChain, shapes: Array, omega: float) -> dict[str, float]:
    """Share of the strain energy in the pendants' springs and in what springs the chain to the ground.

    The strain energy of a shape of unit modal mass is one half omega^2.
    """
    parts, stored = chain.chain, {}
    hung = shapes[parts.masses.size :]
    for name, pendant, motion in zip(chain.pendant_springs, parts.pendants, hung, strict=False):
        stored[name] = pendant.stiffness * float(np.mean((motion - shapes[pendant.joint]) ** 2))
    if chain.ground:
        springs = np.append(parts.ground_springs, [pendant.ground for pendant in parts.pendants])
        stored[chain.ground] = float(springs @ np.mean(shapes**2, axis=1))
    return {name: energy / omega**2 for name, energy in stored.items()}


def _pulley_family(chain: LabelledChain, shapes: Array) -> str:
    mass = chain.chain.masses.sum() + chain.chain.cable_mass
    rims = {
        name: shapes[chain.joints.index(name)] for name in (DRIVE_PULLEY, LOAD_PULLEY) if name in chain.joints
    }
    if not rims:
        return "chain"
    turning = [name for name, u in rims.items() if np.sum(u**2) * mass > _AT_REST**2]
    if not turning:
        return "pulleys at rest"
    if len(turning) == 1:
        return f"{turning[0]} turning"
    drive, load = rims[DRIVE_PULLEY], rims[LOAD_PULLEY]
    product, size = np.sum(drive * load), np.sqrt(np.sum(drive**2) * np.sum(load**2))
    if abs(product) < 0.5 * size:
        return "pulleys independent"
    return "pulleys in phase" if product > 0 else "pulleys out of phase"
