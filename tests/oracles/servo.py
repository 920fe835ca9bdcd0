"""A virtual rig inside the loop of its position servo: the logs that most machines give."""

from dataclasses import dataclass
from math import exp, floor, inf, pi

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.logs.log import Log
from cabledrive.mechanics.compiled import njit
from cabledrive.rig.bench.virtual_rig import VirtualRig, friction_and_gaps, log_from
from oracles.servo_plant import Row, moved

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Servo:
    """PD on the motor's encoder.

    ``bandwidth``: of the loop around an axis without friction [Hz]; ``damping``: of that loop;
    ``speed_filter``: low-pass of the first order behind the backward difference of the encoder's angle [Hz].
    """

    bandwidth: float = 6.0
    damping: float = 0.8
    speed_filter: float = 50.0


def run_servo(
    rig: VirtualRig,
    reference: Array,
    rng: np.random.Generator,
    servo: Servo | None = None,
    *,
    oversampling: int = 4,
    source: str = "virtual rig with servo",
) -> Log:
    """Move a rig along a reference and log what its instruments say.

    The controller reads the encoder "angle" once per sample. Torque, amplifier and log are those of
    `cabledrive.rig.bench.virtual_rig.run_rig`.

    ``rig``: with the encoder "angle"; ``reference``, shape (2, samples): wanted angle of the motor [rad] and
    its speed [rad/s]; ``oversampling``: even; steps per sample.
    Returns channels "torque" and one per encoder.
    """
    servo = servo or Servo()
    flaws, samples, interval = rig.imperfections, reference.shape[1], 1.0 / rig.sample_rate
    phases = {name: float(rng.uniform()) for name in rig.encoders}
    inertia, omega = sum(rig.chain.inertias), 2 * pi * servo.bandwidth
    fine = interval / oversampling
    pole = 0.0 if flaws.current_bandwidth is None else exp(-2 * pi * flaws.current_bandwidth * fine)
    follow = 1.0 - exp(-2 * pi * servo.speed_filter * interval)
    most = inf if rig.torque_limit is None else rig.torque_limit
    quantum = 2 * pi / rig.encoders["angle"]
    gains = (inertia * omega**2, 2 * servo.damping * inertia * omega)
    torque, angles = np.empty((samples, oversampling)), np.empty((samples, rig.chain.size))
    integrate_servo(
        row_of(rig),
        np.array([*gains, follow, quantum, phases["angle"], pole, most]),
        np.ascontiguousarray(reference),
        np.asarray(flaws.amplifier_noise * rng.normal(size=samples)),
        interval,
        torque,
        angles,
    )
    return log_from(rig, torque.ravel(), angles, rng, {}, source, phases)


def row_of(rig: VirtualRig) -> Row:
    """The inertias of a rig with what its imperfections add."""
    chain, (law, gaps) = rig.chain, friction_and_gaps(rig)
    ratios = np.array(chain.ratios, dtype=float).reshape(chain.size - 1, 2)
    fields = (chain.inertias, chain.viscous, chain.coulomb, chain.offsets, law.excess, law.fading, law.slope)
    links = (chain.stiffness, chain.damping, gaps, *ratios.T)
    return Row(*(np.array(values, dtype=float) for values in (*fields, *links)))


@njit
def integrate_servo(
    row: Row, loop: Array, reference: Array, noise: Array, interval: float, torque: Array, angles: Array
) -> None:
    """Torque at every fine step, angles at every sample.

    ``loop`` holds the position gain, the speed gain, the share by which the measured speed follows the
    backward difference in one sample, the step and the phase of the encoder, the pole of the current loop
    over a fine step and the largest torque. ``reference`` holds angle and speed at the samples, ``noise`` the
    amplifier's torque; the controller works once per sample and its torque stands until the next.
    ``torque`` has shape (samples, oversampling), ``angles`` (samples, n).
    """
    n, parts = row.inertia.size, torque.shape[1]
    kp, kv, follow, quantum, phase, pole, most = loop
    x, ways = np.zeros(2 * n), np.zeros(n)
    x[:n] = reference[0, 0]
    before = quantum * floor(x[0] / quantum + phase)
    speed, acting = 0.0, 0.0
    for sample in range(reference.shape[1]):
        angles[sample] = x[:n]
        shown = quantum * floor(x[0] / quantum + phase)
        speed += follow * ((shown - before) / interval - speed)
        before = shown
        wanted = kp * (reference[0, sample] - shown) + kv * (reference[1, sample] - speed)
        wanted = min(max(wanted, -most), most) + noise[sample]
        for part in range(parts):
            last = acting
            acting = pole * acting + (1.0 - pole) * wanted
            torque[sample, part] = last
            x = moved(row, x, ways, last, acting, interval / parts)
