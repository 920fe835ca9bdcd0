r"""Motion wanted of a body between two motors, the gains of its law, and the poles of its loop.

With a delay :math:`\tau` from sample to torque a loop of two equal poles :math:`\omega` crosses at
:math:`2.06\,\omega`; :math:`\omega\tau = 0.17` costs it 20 of its 76 degrees of phase.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import isfinite, pi, sqrt

import numpy as np

from cabledrive.control.tension_position import TensionGains
from cabledrive.parameters import InputRefused, Sensors
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import require_known
from cabledrive.parameters.route import posed
from cabledrive.reduction.two_motors import TwoMotorMachine, TwoMotors, line_at
from cabledrive.rig.setting import BodyMotion

DELAY_SHARE = 0.17
LINE_SHARE = 0.2
"""Of the lowest frequency that the model leaves out, for the bandwidth of the tension."""
POSITION_SHARE, OBSERVER_SHARE = 1.0 / 12.0, 0.15
"""Of the bandwidth of the tension."""
TORQUE_SHARE = 0.95
"""Of the torque limit, for tension, friction and a drum that follows its line at 1 g."""
FLOOR_SHARE, GUST_SHARE = 0.2, 0.1
EARTH = 9.81
"""Acceleration that a drum can follow, and the weight of a body that lies level [m/s^2]."""
SLIDING = 0.01
"""Speed of the body below which the friction of the drums is smoothed [m/s]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TensionDesign:
    """The law of a machine and what it promises."""

    gains: TensionGains
    floor: float  # least tension allowed [N]
    gust: float  # largest force on the body for which the floor is promised [N]
    margin: Array  # (2,): kept above the floor for it [N]
    # of the machine: one count of the drums' encoders [rad], noise of the load cells [N], delay [s], rate of
    # the slower torque loop [rad/s], 0: ideal
    count: float
    noise: float
    delay: float
    rate: float


def design_tensions(
    machine: TwoMotorMachine,
    *,
    least_tension: float | None = None,
    gust: float | None = None,
    bandwidth: float | None = None,
) -> TensionDesign:
    """Gains and limits of the law; ``least_tension``, ``gust`` [N], ``bandwidth`` of the position [Hz]."""
    numbers, drive = machine.numbers, machine.drive
    floor = FLOOR_SHARE * float(machine.tension.min()) if least_tension is None else least_tension
    gust = GUST_SHARE * EARTH * float(numbers.mass.max()) if gust is None else gust
    for name, value in (("least_tension", floor), ("gust", gust)):
        if not isfinite(value) or value < 0.0:
            raise InputRefused(f"{name} = {value:.4g} N must be finite and not negative: give a force")
    sensors = drive.sensors or Sensors()
    if sensors.sample_rate is None or sensors.motor_encoder is None or sensors.load_cell_noise is None:
        read = {"sample_rate": '"1 kHz"', "motor_encoder": "COUNTS", "load_cell_noise": '"5 N"'}
        missing = [f"sensors.{name} = {own}" for name, own in read.items() if getattr(sensors, name) is None]
        raise InputRefused(
            "the law samples the angles of both drums and the tensions of both lines: add "
            + ", ".join(missing)
        )
    interval = 1.0 / sensors.sample_rate
    rates = [motor.current_bandwidth for motor in drive.motor if motor.current_bandwidth is not None]
    rate = 2.0 * pi * min(rates, default=0.0)
    delay = 1.5 * interval + sensors.delay + (1.0 / rate if rates else 0.0)
    fastest = min(DELAY_SHARE / delay, LINE_SHARE * machine.left_out)
    position = POSITION_SHARE * fastest if bandwidth is None else 2.0 * pi * bandwidth
    if not 0.0 < position <= 2.0 * POSITION_SHARE * fastest:
        raise InputRefused(
            f"bandwidth = {position / 2.0 / pi:.4g} Hz must lie above 0 and not above "
            f"{2.0 * POSITION_SHARE * fastest / 2.0 / pi:.4g} Hz, a sixth of that of the tension: lower it"
        )
    last = np.sqrt(((numbers.anchor - numbers.centre) ** 2).sum(axis=1) - numbers.radius**2)
    stiffness = numbers.rigidity / (numbers.fixed + last)
    unexpected = gust / numbers.mass.min() + numbers.drum * numbers.turning_coulomb / numbers.inertia
    noise = 3.0 * sensors.load_cell_noise * sqrt(fastest * interval)
    margin = stiffness * unexpected / fastest**2 + noise
    following = numbers.turning_coulomb + numbers.inertia * EARTH / numbers.drum
    high = (TORQUE_SHARE * numbers.limit - following) / numbers.drum
    low = floor + margin
    for line, rest, least, most in zip(machine.lines, machine.tension, low, high, strict=True):
        if not least < rest < most:
            raise InputRefused(
                f"{line}: its tension at rest of {rest:.4g} N is not between {least:.4g} N (least tension "
                f"{floor:.4g} N and a margin for gusts of {gust:.4g} N) and {most:.4g} N "
                "(motor.torque_limit less what the drum takes): lower one, or choose another place"
            )
    gains = TensionGains(
        machine=numbers,
        low=low,
        high=high,
        preferred=machine.tension.copy(),
        position=position,
        filter=fastest,
        tension=fastest,
        observer=OBSERVER_SHARE * fastest,
        sliding=SLIDING / float(numbers.drum.max()),
        interval=interval,
    )
    return TensionDesign(
        gains=gains,
        floor=floor,
        gust=gust,
        margin=margin,
        count=2.0 * pi / sensors.motor_encoder,
        noise=sensors.load_cell_noise,
        delay=sensors.delay,
        rate=rate,
    )


DEFAULT_WAY = 0.05
"""Of the distance between the last pulleys."""
USED = 0.8
"""Part of torque, speed and tension below rest that the motion may use where its rise is chosen."""
LONGEST_RISE = 600.0
_HALVINGS, LOOKED_AT = 40, 399


@dataclass(frozen=True, kw_only=True, eq=False)
class Setup:
    """What all runs share: a machine as believed, its law, a motion and what that asks for."""

    machine: TwoMotorMachine
    design: TensionDesign
    task: BodyMotion  # with its rise
    table: Array  # (samples, 3 m + 2): as `cabledrive.control.tension_position.step_in_place` takes it
    # tension, torque, speed: (samples, 2): of lines [N], drums [N m] and [rad/s]
    tension: Array
    torque: Array
    speed: Array

    @property
    def used(self) -> float:
        """Largest part of what tension, torque and speed allow; above 1: it cannot be followed."""
        rest, numbers = self.machine.tension, self.machine.numbers
        parts = [((rest - self.tension) / (rest - self.design.gains.low)).max()]
        parts += [(np.abs(self.torque) / numbers.limit).max()]
        limits = [motor.speed_limit for motor in self.machine.drive.motor]
        parts += [np.abs(own).max() / limit for own, limit in zip(self.speed.T, limits, strict=True) if limit]
        return float(max(parts))


def way_of(machine: TwoMotorMachine, moves: Mapping[str, float]) -> Array:
    """How far each coordinate goes, shape (m,) [m]; without moves a little way towards the nearer middle."""
    if not moves:
        axis, centre = "xy".index(machine.names[0][-1]), machine.numbers.centre
        size = DEFAULT_WAY * float(np.abs(centre[1] - centre[0]).max())
        before = machine.numbers.anchor[:, axis].mean() <= float(centre[:, axis].mean())
        moves = {machine.names[0]: size if before else -size}
    for name, value in moves.items():
        require_known(name[:60], machine.names, f'move = "{name[:60]}" is no coordinate of the body')
        if not np.isfinite(value):
            raise InputRefused(f"move {name} = {value} m must be finite: give a distance")
    return np.array([moves.get(name, 0.0) for name in machine.names])


def plan_motion(machine: TwoMotorMachine, design: TensionDesign, way: Array, motion: BodyMotion) -> Setup:
    """Go a way and back, smoothly; without a rise the shortest that uses at most `USED` of the limits."""
    drive = machine.drive
    at = [drive.body[0].at["xy".index(name[-1])] for name in machine.names]
    for share in (0.25, 0.5, 0.75, 1.0):  # where the machine of the file cannot be
        try:
            posed(drive, dict(zip(machine.names, (at + share * way).tolist(), strict=True)))
        except InputRefused as refusal:
            raise InputRefused(f"move: {refusal}") from None
    if not way.any():
        raise InputRefused("move: no coordinate moves: give a distance, such as camera.x=2m")
    if motion.rise is None:
        single = [0.01, LONGEST_RISE]

        def asks(rise: float) -> float:
            once = replace(motion, rise=rise, dwell=0.0, pulses=1)
            return _plan(machine, design, way, once, once.trajectory.duration / LOOKED_AT).used

        if asks(single[1]) > USED:
            raise InputRefused(
                f"move: even in {LONGEST_RISE:.0f} s it takes more than {USED:.0%} of what torque and least "
                "tension allow: go less far, or lower the least tension"
            )
        for _ in range(_HALVINGS):
            middle = float(np.sqrt(single[0] * single[1]))
            single[asks(middle) <= USED] = middle
        motion = replace(motion, rise=float(f"{single[1]:.3g}") * 1.01)
    return _plan(machine, design, way, motion, design.gains.interval)


def _plan(
    machine: TwoMotorMachine, design: TensionDesign, way: Array, task: BodyMotion, step: float
) -> Setup:
    """Tables over samples a ``step`` [s] apart."""
    numbers, gains, s = machine.numbers, design.gains, task.sampled(step, 2)
    q, v, a = (s[k][:, None] * way for k in range(3))
    along, length, free = lines_along(numbers, q)
    friction = numbers.viscous * v + numbers.coulomb * np.tanh(1e3 * v)
    smooth = held_tensions(gains.preferred, along, numbers.force - numbers.mass * a - numbers.viscous * v)
    tension = held_tensions(gains.preferred, along, numbers.force - numbers.mass * a - friction)
    rate = np.gradient(smooth, step, axis=0)
    bent = np.gradient(rate, step, axis=0)
    stretch = tension * free / numbers.rigidity
    speed = np.gradient(stretch - length, step, axis=0) / numbers.drum
    wound = smooth * free / numbers.rigidity - length
    acceleration = np.gradient(np.gradient(wound, step, axis=0), step, axis=0)
    torque = (
        numbers.drum * tension
        + numbers.inertia * acceleration / numbers.drum
        + numbers.turning_viscous * speed
        + numbers.turning_coulomb * np.tanh(speed / gains.sliding)
    )
    lead = 2.0 * rate / gains.filter + bent / gains.filter**2
    return Setup(
        machine=machine,
        design=design,
        task=task,
        table=np.ascontiguousarray(np.hstack([q, v, a, lead])),
        tension=tension,
        torque=torque,
        speed=speed,
    )


def lines_along(machine: TwoMotors, q: Array) -> tuple[Array, Array, Array]:
    """Slopes dL/dq, shape (samples, 2, m), L and free lengths, shape (samples, 2) [m]."""
    along = np.zeros((len(q), 2, q.shape[1]))
    length, free = np.zeros((len(q), 2)), np.zeros((len(q), 2))
    for k, place in enumerate(q):
        for i in range(2):
            length[k, i], free[k, i], _ = line_at(machine, i, place, along[k, i])
    return along, length, free


def held_tensions(preferred: Array, along: Array, force: Array) -> Array:
    """Tensions nearest to the preferred ones that put a force on the body, shape (samples, 2)."""
    missing = force - np.einsum("kim,i->km", along, preferred)
    return preferred + np.einsum("kim,km->ki", np.linalg.pinv(along.transpose(0, 2, 1)), missing)
