"""Hoists and an elastic axis by scipy, without any part of the package: plain Newton."""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

GRAVITY = 9.81


@dataclass(frozen=True)
class Hoist:
    """A load that hangs on a rope below a drum whose turn is given, in SI.

    Material points stand in the rope at fixed labels, counted from the load. The piece between the highest
    one and the drum becomes shorter; where it is a quarter of a spacing long the point goes onto the drum.
    """

    rigidity: float
    density: float
    length: float  # free, at the start
    mass: float
    radius: float
    points: int

    def run(self, turn, duration, samples, rtol=1e-08):
        """Places of the load below the drum and tensions beside it; ``turn(t)``: angle, speed."""
        tension = self.mass * GRAVITY
        weight, whole = self.density * GRAVITY, self.length
        # T = tension + weight s at the label s; free length = s + (tension s + weight s^2/2)/EA
        a, b = weight / (2.0 * self.rigidity), 1.0 + tension / self.rigidity
        label = (-b + np.sqrt(b * b + 4.0 * a * whole)) / (2.0 * a)
        spacing = label / (self.points + 0.5)
        at = spacing * (np.arange(self.points) + 0.5)
        place = whole - (at + (tension * at + weight * at**2 / 2.0) / self.rigidity)  # below the drum
        state = np.concatenate([[whole], place, np.zeros(self.points + 1), [label]])
        alive, t, found = self.points, 0.0, []
        while t < duration - 1e-12:

            def leaves(_, y, n=alive):
                return y[-1] - spacing * (n - 0.25)

            leaves.terminal, leaves.direction = True, -1
            solved = solve_ivp(
                lambda t, y, n=alive: self._rate(t, y, n, spacing, turn),
                (t, duration),
                state,
                method="DOP853",
                rtol=rtol,
                atol=1e-9,
                events=leaves if alive > 1 else None,
                dense_output=True,
            )
            last = found[-1][0] if found else -1.0
            for moment in samples[(samples > last) & (samples <= solved.t[-1])]:
                y = solved.sol(moment)
                top = self._tensions(y, alive, spacing)[0]
                found.append((moment, y[0], top))
            t, state = solved.t[-1], solved.y[:, -1]
            if solved.status == 1:
                speeds = state[alive + 1 : 2 * alive + 2]
                state = np.concatenate([state[:alive], speeds[:-1], state[-1:]])
                alive -= 1
        return np.array(found)

    def _tensions(self, y, n, spacing):
        """From the drum down to the load."""
        place = np.concatenate([[0.0], y[n:0:-1], y[:1]])  # drum, points from above, load
        own = np.concatenate([[y[-1] - spacing * (n - 0.5)], np.full(n - 1, spacing), [0.5 * spacing]])
        return self.rigidity * (np.diff(place) / own - 1.0)

    def _rate(self, t, y, n, spacing, turn):
        pulls = self._tensions(y, n, spacing)
        _, speed = turn(t)
        ends = np.full(n, self.density * spacing)
        points = GRAVITY + (pulls[1:] - pulls[:-1])[::-1] / ends
        load = GRAVITY - pulls[-1] / self.mass
        wound = -self.radius * speed / (1.0 + pulls[0] / self.rigidity)
        return np.concatenate([y[n + 1 : 2 * n + 2], [load], points, [wound]])


@dataclass(frozen=True)
class Traction:
    """Car and counterweight on ropes without mass over a sheave: rope sticks, and creeps where it leaves."""

    rigidity: float
    lengths: tuple[float, float]  # free, at the start
    masses: tuple[float, float]
    radius: float

    def run(self, turn, duration, samples):
        """Drops of both masses; a positive speed of the sheave pays rope out to the first."""
        tension = np.array(self.masses) * GRAVITY
        start = np.array(self.lengths) / (1.0 + tension / self.rigidity)

        def rate(t, y):
            drop, speed, rope = y[:2], y[2:4], y[4:]
            strain = (np.array(self.lengths) + drop) / rope - 1.0
            _, omega = turn(t)
            carried = strain[1] if omega > 0.0 else strain[0]
            passed = self.radius * omega / (1.0 + carried)
            pull = self.rigidity * strain
            return np.concatenate([speed, GRAVITY - pull / np.array(self.masses), [passed, -passed]])

        y = np.concatenate([np.zeros(4), start])
        solved = solve_ivp(rate, (0.0, duration), y, "LSODA", samples, rtol=1e-10, atol=1e-12)
        return solved.y[:2].T


def span_tensions(time, torque, radius, motor, load, stiffness, pretension):
    """Tensions of two spans between a motor and a load, shape (2, t); the torque on straight lines."""

    def rates(t, state):
        turn_motor, turn_load, speed_motor, speed_load = state
        pull = 2.0 * stiffness * radius**2 * (turn_motor - turn_load)
        push = np.interp(t, time, torque)
        return [speed_motor, speed_load, (push - pull) / motor, pull / load]

    found = solve_ivp(
        rates,
        (time[0], time[-1]),
        np.zeros(4),
        t_eval=time,
        rtol=1e-10,
        atol=1e-14,
        max_step=time[1] - time[0],
    )
    rise = stiffness * radius * (found.y[0] - found.y[1])
    return np.array([pretension + rise, pretension - rise])
