"""A lumped chain for the reader: sticking motor, rubbing load, backlash, slack spans, a torque loop, a law.

The equations stand here as in a textbook, on plain numbers. Every short step is one of Runge and Kutta; the
instant at which the motor stops or lets go is found by halving the step. Nothing is taken from the rig.
"""

from dataclasses import dataclass
from math import copysign, inf, tanh

import numpy as np
from benchmarks.sampled_loops import darc_step

from cabledrive.control.numbers import KALMAN, NOMINAL
from cabledrive.reduction.lumped_chain import LumpedChain

HALVINGS = 40


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadablePlant:
    """A chain between equal angles and what a drive adds to it.

    ``rate``: bandwidth of the torque loop [rad/s]; 0: none; ``play``: backlash of the first link, from end to
    end [rad]; ``slack``: twist of the last link beyond which one of its two spans carries nothing [rad];
    ``slope``: K of the load's friction c tanh(K w) [s/rad]; ``step``: of Runge and Kutta [s].
    """

    chain: LumpedChain
    rate: float = 0.0
    play: float = 0.0
    slack: float = inf
    slope: float = 50.0
    step: float = 5e-6

    def link(self, i, x):
        """Torque that link i takes from inertia i and gives to the next [N m]."""
        n = self.chain.size
        stiffness, damping = self.chain.stiffness[i], self.chain.damping[i]
        twist, speed = x[i] - x[i + 1], x[n + i] - x[n + i + 1]
        if i == 0 and self.play > 0.0:
            if abs(twist) < 0.5 * self.play:
                return 0.0
            pressed = stiffness * (abs(twist) - 0.5 * self.play) + damping * copysign(speed, twist * speed)
            return copysign(max(pressed, 0.0), twist)  # a flank pushes and cannot pull
        if i == n - 2 and abs(twist) > self.slack:
            taut = copysign(self.slack, twist)  # one span is left, of half the stiffness of both
            return stiffness * (taut + 0.5 * (twist - taut)) + 0.5 * damping * speed
        return stiffness * twist + damping * speed

    def torques(self, x):
        """Torque on every inertia without the motor's Coulomb friction."""
        chain, n = self.chain, self.chain.size
        found = [-b * w for b, w in zip(chain.viscous, x[n : 2 * n], strict=True)]
        found[0] += x[2 * n] + chain.offsets[0]
        if n > 1:
            found[-1] -= chain.coulomb[-1] * tanh(self.slope * x[2 * n - 1])
        for i in range(n - 1):
            through = self.link(i, x)
            found[i] -= through
            found[i + 1] += through
        return found

    def rates(self, x, slip, u):
        """Rates of angles, speeds and shaft torque; ``slip``: way of the motor, 0 where it sticks."""
        n = self.chain.size
        found = self.torques(x)
        found[0] -= slip * self.chain.coulomb[0]
        speeds = [torque / inertia for torque, inertia in zip(found, self.chain.inertias, strict=True)]
        if slip == 0 and self.chain.coulomb[0] > 0.0:
            speeds[0] = 0.0
        return [*x[n : 2 * n], *speeds, self.rate * (u - x[2 * n])]

    def stepped(self, x, slip, u, h):
        """State one step of Runge and Kutta on."""
        one = self.rates(x, slip, u)
        two = self.rates([a + 0.5 * h * r for a, r in zip(x, one, strict=True)], slip, u)
        three = self.rates([a + 0.5 * h * r for a, r in zip(x, two, strict=True)], slip, u)
        four = self.rates([a + h * r for a, r in zip(x, three, strict=True)], slip, u)
        return [
            a + h / 6.0 * (p + 2.0 * (q + r) + s)
            for a, p, q, r, s in zip(x, one, two, three, four, strict=True)
        ]

    def way(self, x):
        """Which way a motor at rest lets go; 0: friction holds it."""
        torque = self.torques(x)[0]
        return 0 if abs(torque) <= self.chain.coulomb[0] else int(copysign(1, torque))

    def changes(self, x, slip):
        """Whether the motor has let go, or has turned."""
        if slip == 0:
            return self.way(x) != 0
        return slip * x[self.chain.size] < 0.0

    def moved(self, x, slip, u, time):
        """State and way of the motor after a time under a constant command [N m]."""
        n, rest = self.chain.size, time
        if self.rate == 0.0:
            x = [*x[: 2 * n], u]
        sticks = self.chain.coulomb[0] > 0.0
        if sticks and slip == 0:
            slip = self.way(x)
        while rest > 1e-15:
            h = min(self.step, rest)
            later = self.stepped(x, slip, u, h)
            if sticks and self.changes(later, slip):
                early, late = 0.0, h
                for _ in range(HALVINGS):
                    h = 0.5 * (early + late)
                    later = self.stepped(x, slip, u, h)
                    early, late = (early, h) if self.changes(later, slip) else (h, late)
                h = late
                later = self.stepped(x, slip, u, h)
                later[n] = 0.0
                slip = self.way(later)
            x, rest = later, rest - h
        return x, slip


def run_reference(loop, samples):
    """A run with Kalman filter or ideal states, no delay nor jitter; the law is the benchmark's in numpy.

    Returns ``commands, load_angles``, shape (samples,) [N m], [rad] at the first shaft.
    """
    rig, observer, law, n = loop.rig, loop.observer, loop.controller.law, loop.chain.size
    plant = ReadablePlant(chain=loop.chain, rate=loop.plant.current_rate)
    moving, slip, held, newest = [0.0] * (2 * n + 1), 0, 0.0, 0.0
    believed, estimate = np.zeros(observer.model.shape[0]), law.learning[NOMINAL].copy()
    commands, angles = np.zeros(samples), np.zeros(samples)
    for k in range(samples):
        x = np.array(moving)
        angles[k] = x[n - 1]
        if observer.kind == KALMAN:
            counts = np.rint(x[rig.encoders] / rig.counts + rig.phases)
            gain = observer.gains[min(k, len(observer.gains) - 1)]
            believed += gain @ (rig.counts * counts - observer.output @ believed)
            states = believed[observer.chosen]
        else:
            states = x[observer.chosen]
        command, estimate = darc_step(law, estimate, states, loop.controller.reference[k])
        older, newest = newest, np.clip(command, -rig.torque_limit, rig.torque_limit)
        if observer.kind == KALMAN:
            scalars = observer.scalars
            torques = [held, older, newest]  # of the shaft, commands before and after the delay has passed
            friction = scalars[5] * np.tanh(scalars[6] * believed[n])
            believed = observer.model @ np.concatenate((believed, torques, [scalars[7] - friction]))
            held = float(scalars[2:5] @ torques)
        commands[k] = newest
        moving, slip = plant.moved(moving, slip, float(newest), rig.interval)
    return commands, angles
