"""Two winches, two sheaves and a body in the plane by scipy: arcs from angles, directions by differences."""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp


@dataclass(frozen=True)
class Winches:
    """Left line over the top of the left sheave, right line over the top of the right one."""

    sheaves: np.ndarray  # (2, 2) centres [m]
    sheave_radius: float
    clamps: np.ndarray  # (2, 2) at rest [m]
    vertical: float  # free length from drum to sheave [m]
    rigidity: float
    loss: float
    drum: float
    inertia: float  # of each drum with all that turns
    viscous: float
    coulomb: float  # smoothed over 0.2 mrad/s
    mass: float
    weight: float

    def length(self, i, q):
        """Whole length from the drum but for a constant, and its free part [m]."""
        d = self.clamps[i] + q - self.sheaves[i]
        distance, r = np.hypot(*d), self.sheave_radius
        free, slope = np.sqrt(distance**2 - r**2), np.arctan2(d[1], d[0])
        if (
            i == 0
        ):  # the contact lies above the line of centres to the right: clockwise arc from the left side
            return free - r * (slope + np.arccos(r / distance)), free + self.vertical
        slope %= 2.0 * np.pi
        return free + r * (slope - np.arccos(r / distance)), free + self.vertical

    def slopes(self, i, q):
        """Change of the length with the body's place, by central differences."""
        h = 1e-5 * np.eye(2)
        return np.array([(self.length(i, q + e)[0] - self.length(i, q - e)[0]) / 2e-5 for e in h])

    def tensions(self, x, unwound):
        """Tensions, shape (2,), and slopes, shape (2, 2); x: q, v, angles, speeds."""
        q, v, angle, turn = np.split(x, 4)
        slopes = np.array([self.slopes(i, q) for i in range(2)])
        found = np.zeros(2)
        for i in range(2):
            length, free = self.length(i, q)
            stretch = length + self.drum * angle[i] - unwound[i]
            rate = slopes[i] @ v + self.drum * turn[i]
            if stretch > 0.0:
                found[i] = max((self.rigidity * stretch + self.loss * rate) / free, 0.0)
        return found, slopes

    def at_rest(self):
        """Tensions that carry the weight at the place of the file, and what is unwound for them."""
        slopes = np.array([self.slopes(i, np.zeros(2)) for i in range(2)])
        tension = np.linalg.solve(slopes.T, np.array([0.0, -self.weight]))
        lines = [self.length(i, np.zeros(2)) for i in range(2)]
        return tension, np.array(
            [a - t * b / self.rigidity for (a, b), t in zip(lines, tension, strict=True)]
        )

    def motion(self, x, torque, force, unwound):
        """Rate of q, v, angles, speeds."""
        tension, slopes = self.tensions(x, unwound)
        turn = x[6:]
        rubbed = self.viscous * turn + self.coulomb * np.tanh(turn / 2e-4)
        body = (force + np.array([0.0, -self.weight]) - tension @ slopes) / self.mass
        return np.concatenate([x[2:4], body, turn, (torque - self.drum * tension - rubbed) / self.inertia])


def run(winches, law, reference, force, interval, rtol=1e-08):
    """Under a sampled law ``law(angles, tensions, row) -> torques``; places, tensions, least tension."""
    tension, unwound = winches.at_rest()
    x, places, tensions, least = np.zeros(8), [], [], tension.min()
    for row, push in zip(reference, force, strict=True):
        tension, _ = winches.tensions(x, unwound)
        places.append(x[:2].copy())
        tensions.append(tension)
        torque = law(x[4:6].copy(), tension, row)
        step = solve_ivp(
            lambda _, y, u=torque, f=push: winches.motion(y, u, f, unwound),
            (0.0, interval),
            x,
            method="LSODA",
            rtol=rtol,
            atol=1e-9,
        )
        x = step.y[:, -1]
        least = min(least, *(winches.tensions(y, unwound)[0].min() for y in step.y.T[-2:]))
    return np.array(places), np.array(tensions), least
