"""Two motors on one shaft, each through a dead zone, and a load behind a cable, by scipy."""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp


@dataclass(frozen=True)
class MotorPair:
    """Motors of one size; angles: motor a, motor b, shaft, load."""

    motor: float  # inertia of each [kg m^2]
    viscous: float  # of each motor
    stiffness: float  # of each joint
    loss: float
    gap: float  # of each gear, from end to end [rad]
    shaft: float  # inertia
    load: float
    cable: float  # stiffness
    cable_loss: float
    rate: float  # of the torque loops [rad/s]

    def contact(self, twist, speed):
        """Torque of a gear on its shaft: a spring and damper that only push, on either flank."""
        beyond = abs(twist) - 0.5 * self.gap
        if beyond <= 0.0:
            return 0.0
        side = np.sign(twist)
        return side * max(self.stiffness * beyond + self.loss * side * speed, 0.0)

    def motion(self, x, commands, push):
        """Rate of four angles, four speeds and two torques."""
        angle, speed, torque = x[:4], x[4:8], x[8:]
        gears = [self.contact(angle[i] - angle[2], speed[i] - speed[2]) for i in range(2)]
        rope = self.cable * (angle[2] - angle[3]) + self.cable_loss * (speed[2] - speed[3])
        turning = [(torque[i] - gears[i] - self.viscous * speed[i]) / self.motor for i in range(2)]
        turning += [(sum(gears) - rope) / self.shaft, (rope + push) / self.load]
        return np.concatenate([speed, turning, self.rate * (commands - torque)])


def run(pair, preload, commands, push, interval):
    """From rest under the preload: angles at the samples, shape (samples, 4), and torques of both flanks."""
    turned = 0.5 * pair.gap + preload / pair.stiffness
    x = np.concatenate([[turned, -turned], np.zeros(6), [preload, -preload]])
    angles, flanks = [], []
    for asked, load in zip(commands, push, strict=True):
        angles.append(x[:4])
        flanks.append([s * pair.contact(x[i] - x[2], x[4 + i] - x[6]) for i, s in enumerate((1.0, -1.0))])
        step = solve_ivp(
            lambda _, y, u=asked, f=load: pair.motion(y, u, f), (0.0, interval), x, rtol=1e-9, atol=1e-11
        )
        x = step.y[:, -1]
    return np.array(angles), np.array(flanks)
