r"""The pulley mode and the transverse modes near half its frequency: the model of internal resonance.

With q the relative displacement of the two rims in the pulley mode, :math:`a_j` the amplitudes of the
transverse modes (one for each section and plane) and v the rim speed of the rigid rotation, the energy of
chapter 2 gives

.. math::
    M(\ddot q + c_q\dot q + W^2 q) + c_{12} v &= \phi_\tau\tau/r_1 - \sum_j G_j a_j^2 \\
    m_j(\ddot a_j + \Gamma\dot a_j + w_j^2 a_j) + 2 G_j q\,a_j + a_j\sum_k N_{jk} a_k^2 &= 0 \\
    M_0\dot v + c_{11} v + c_{12}\dot q &= \tau/r_1 \qquad\qquad \text{Eq. (A.9)}
"""

from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np

from cabledrive.mechanics.chain import LabelledChain
from cabledrive.mechanics.holding import FREE, modal_losses, motor_condition, shaft_frictions
from cabledrive.mechanics.rest import rest_state
from cabledrive.mechanics.spans import rigid_mass, transverse_chains
from cabledrive.modal.shapes import SlopeWave
from cabledrive.modal.tuning import PulleyMode, pulley_mode, rims_of
from cabledrive.parameters import Drive, Machine
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route.two_pulleys import two_pulleys_of
from cabledrive.reduction import transverse_sections as across
from cabledrive.reduction.stretches import StretchModel


def scaled_rims(pulley: PulleyMode) -> tuple[Array, float]:
    """Displacements of drive rim, load rim and motor per q, (3,), and the root of the modal mass [kg^1/2].

    q is the displacement of the load rim relative to the drive rim; in modes where the two go together, the
    larger of both.
    """
    rims = rims_of(pulley.mode, pulley.shape)
    drive, load, _ = rims
    scale = load - drive
    if abs(scale) < 0.1 * max(abs(drive), abs(load)):
        scale = load if abs(load) > abs(drive) else drive
    return rims / scale, float(1.0 / scale)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AutoparametricModel:
    """Coefficients of the model; J transverse modes, the w plane's first."""

    natural: float  # frequency W of the pulley mode [rad/s]
    modal_mass: float  # M [kg]
    modal_damping: float  # c_q [1/s]
    rims: tuple[float, float]  # displacement of drive rim and load rim per q
    torque_arm: float  # phi_tau / r1: force on q per torque [1/m]
    rigid_arm: float  # 1 / r1: force on the rigid rotation per torque [1/m]; 0: pulley or motor held
    rigid_mass: float  # mass M0 of the rigid rotation at the rim [kg]
    rigid_damping: float  # c11 [N s/m]
    cross_damping: float  # c12 [N s/m]
    coulomb_force: float  # sum of c phi / r over the shafts: Coulomb friction that opposes q [N]
    modes: tuple[across.TransverseMode, ...]
    transverse: Array  # (J,): frequencies w [rad/s]
    transverse_mass: Array  # (J,) [kg]
    transverse_damping: float  # Gamma of the cable [1/s]
    cable_share: Array  # (J,): of the kinetic energy, the cable's: carriages on it are not damped
    coupling: Array  # (J,): G, positive where a positive q stretches the section [N/m^2]
    stiffening: Array  # (J, J): N [N/m^3]
    slack_amplitude: float  # q at which a span loses its tension somewhere [m]
    uneven: Array  # (J,): part of the diagonal of N that is proportional to T0 [N/m^3]
    load_radius: float  # r2 [m]
    pretension: float  # T0 [N]
    axial_rigidity: float  # EA [N]
    tension_offset: Array  # (J,): tension of each section's span above the pretension, by a steady load [N]

    @property
    def damped(self) -> bool:
        """Whether the pulley mode and the cable across are both damped."""
        return 0.0 not in (self.modal_damping, self.transverse_damping)

    @property
    def sections(self) -> int:
        """Number of vibrating sections: transverse modes in one plane."""
        return sum(mode.plane == across.PLANES[0] for mode in self.modes)


def autoparametric_model(
    drive: Machine | Drive,
    *,
    number: int | None = None,
    planes: int = 1,
    load_torque: float = 0.0,
    at_rest: bool = False,
) -> AutoparametricModel:
    """Coefficients of the internal resonance of a drive, Eq. (A.9).

    ``number``: number of the transverse mode of every section; unless given, the one that the pulley mode
    makes grow first; ``planes``, {1, 2}: the plane of the loop alone, or with the horizontal one;
    ``load_torque``: steady torque on the load pulley [N m]; it pulls the upper span and relaxes the lower
    one; ``at_rest``: whether each section has the tension that weights, carriages and slope leave it, instead
    of the pretension of the straight drive.
    Raises `InputRefused` if it is more than one cable between two pulleys, no pulley can turn, or the steady
    torque takes a span's tension away; `NotComputed` if a section hangs slack at rest.
    """
    drive = two_pulleys_of(drive, "internal resonance by closed forms")
    tensions = across.span_tensions(drive, load_torque)
    pulley = pulley_mode(drive)
    moved, factor = scaled_rims(pulley)
    along = [replace(wave, slope=factor * wave.slope) for wave in pulley.mode.slope_waves(pulley.shape)]
    mass = factor**2
    strings, slack = _strings(drive, load_torque, along) if at_rest else (transverse_chains(drive), None)
    sections = [across.nearest_section(chain, pulley.omega, number) for chain in strings]
    coupling = across.coupling_of(drive, along, sections)
    uneven, shared = across.stiffening_of(drive, coupling, sections, mass * pulley.omega**2)
    shafts = [(viscous, coulomb, float(way @ moved)) for viscous, coulomb, way in shaft_frictions(drive)]
    free = not any(p.fixed for p in drive.pulley) and motor_condition(drive) == FREE
    rest, rigidity = drive.cable.pretension, drive.cable.axial_rigidity
    own = np.array([tensions[part.label.span] for part in sections])
    shift = across.frequency_shift(own, rest, rigidity)
    if slack is not None:
        force = np.array([string.chain.rigidity for string in strings])
        own, shift = force / (1.0 - force / rigidity), np.ones(len(sections))
    return AutoparametricModel(
        natural=pulley.omega,
        modal_mass=mass,
        modal_damping=float(modal_losses(drive, moved[None] / factor, np.array([pulley.omega**2]))[0, 0]),
        rims=(float(moved[0]), float(moved[1])),
        torque_arm=float(moved[2] / drive.drive_pulley.radius),
        rigid_arm=1.0 / drive.drive_pulley.radius if free else 0.0,
        rigid_mass=rigid_mass(drive) if free else inf,
        rigid_damping=sum(viscous for viscous, _, _ in shafts[:3]) if free else 0.0,
        cross_damping=sum(viscous * shape for viscous, _, shape in shafts[:3]) if free else 0.0,
        coulomb_force=sum(coulomb * abs(shape) for _, coulomb, shape in shafts),
        modes=tuple(
            replace(part.label, plane=plane) for plane in across.PLANES[:planes] for part in sections
        ),
        transverse=np.tile([part.omega for part in sections] * shift, planes),
        transverse_mass=np.tile([part.mass for part in sections], planes),
        transverse_damping=drive.cable.transverse_damping,
        cable_share=np.tile([part.cable_share for part in sections], planes),
        coupling=np.tile(coupling, planes),
        stiffening=np.tile(np.diag(uneven) + shared, (planes, planes)),
        slack_amplitude=slack
        or min(tensions[span] / (rigidity * across.largest_slope(along, span)) for span in drive.spans),
        uneven=np.tile(uneven, planes),
        load_radius=drive.load_pulley.radius,
        pretension=drive.cable.pretension,
        axial_rigidity=drive.cable.axial_rigidity,
        tension_offset=np.tile(own - rest, planes),
    )


def _strings(
    drive: Drive, load_torque: float, along: list[SlopeWave]
) -> tuple[tuple[LabelledChain, ...], float]:
    """Sections under their tension at rest, and the q at which one of them loses it."""
    at_torque = -load_torque * drive.drive_pulley.radius / drive.load_pulley.radius
    rest = rest_state(drive, at_torque=at_torque)
    strings = transverse_chains(drive, rest=rest)
    slack = min(
        section.lowest_tension / (drive.cable.axial_rigidity * across.largest_slope(along, section.span))
        for section in rest.sections
    )
    return strings, slack


def oscillators(model: AutoparametricModel) -> StretchModel:
    r"""The model as stretches, to be integrated in time, Eq. (A.20); it shows q, each row is one section.

    With unit modal masses along, :math:`G` becomes :math:`2G/\sqrt{M}` and :math:`P_j = a_j^2` carries N/2.
    """
    rigid, sections = model.rigid_arm > 0.0, (model.transverse.size, 1)
    scale = np.array([model.rigid_mass, model.modal_mass]) ** -0.5
    cross = model.cross_damping * scale[0] * scale[1] if rigid else 0.0
    damping = np.array([[model.rigid_damping * scale[0] ** 2, cross], [cross, model.modal_damping]])
    kept = slice(0 if rigid else 1, 2)
    coupling = np.zeros((2, *sections))
    coupling[1, :, 0] = 2.0 * scale[1] * model.coupling
    return StretchModel(
        natural=np.array([0.0, model.natural])[kept],
        damping=np.ascontiguousarray(damping[kept, kept]),
        torque_shape=(scale * [model.rigid_arm, model.torque_arm])[kept],
        transverse=model.transverse.reshape(sections),
        mass=model.transverse_mass.reshape(sections),
        loss=(model.transverse_damping * model.cable_share).reshape(sections),
        sag=np.zeros(sections),
        coupling=coupling[kept],
        square=np.full(sections, 2.0),
        carried=0.5 * model.stiffening,
        probes=np.ones((*sections, 1)),
        motions=np.array([[0.0, scale[1]]])[:, kept],
    )


def at_pretension(model: AutoparametricModel, pretension: Array | float) -> AutoparametricModel:
    r"""Model of the same cable under another pretension, its unstretched lengths kept, Eq. (A.13).

    .. math:: w \propto \sqrt{R}, \quad G \propto (1+\varepsilon_0)^{-2}, \quad
              N \propto (1+\varepsilon_0)^{-4}\ (\text{its uneven part} \propto T_0 (1+\varepsilon_0)^{-4})

    ``pretension``, shape (lanes,): T0 [N]; of an array, every coefficient that changes gets a last axis for
    it.
    """
    tension, rigidity = np.asarray(pretension, dtype=float), model.axial_rigidity
    stretch = (1.0 + tension / rigidity) / (1.0 + model.pretension / rigidity)
    lanes = (slice(None), *[None] * tension.ndim)
    offset = model.tension_offset[lanes]
    old = across.frequency_shift(model.pretension + model.tension_offset, model.pretension, rigidity)
    new = across.frequency_shift(tension + offset, tension, rigidity)
    force = tension / model.pretension / stretch
    n, planes = model.sections, model.uneven.size // model.sections
    own = np.tile(np.diag(model.uneven[:n]), (planes, planes))  # uneven part of N: planes share it
    own = own[(..., *lanes[1:])]
    shared = model.stiffening[(..., *lanes[1:])] - own
    changes: dict[str, Any] = dict(
        transverse=(model.transverse / old)[lanes] * np.sqrt(force) * new,
        coupling=model.coupling[lanes] / stretch**2,
        stiffening=(own * tension / model.pretension + shared) / stretch**4,
        uneven=model.uneven[lanes] * tension / model.pretension / stretch**4,
        slack_amplitude=model.slack_amplitude * tension / model.pretension,
        pretension=tension if tension.ndim else float(tension),
    )
    return replace(model, **changes)


def split_tunings(model: AutoparametricModel) -> dict[str, float | None]:
    """Mean tension at which each span's own mode is tuned under the load [N]; None beyond a factor of 20."""
    from scipy.optimize import brentq

    found: dict[str, float | None] = {}
    for number, mode in enumerate(model.modes):
        low = max(0.05 * model.pretension, 1.0001 * float(np.max(np.abs(model.tension_offset))))
        high = 20.0 * model.pretension

        def _above(tension: float, number: int = number) -> float:
            return float(at_pretension(model, tension).transverse[number]) - 0.5 * model.natural

        inside = _above(low) < 0.0 < _above(high)
        key = mode.span if mode.span not in found else f"{mode.span} from {mode.section[0]:.4g} m"
        found[key] = float(brentq(_above, low, high, xtol=1e-12)) if inside else None
    return found
