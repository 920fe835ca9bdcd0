"""Hoists, an elastic axis, two motors on a shaft, two winches by scipy, without any part of the package."""

from dataclasses import dataclass
from math import acos, atan2, hypot, pi, sqrt

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

    def run(self, turn, duration, samples, rtol=1e-8):
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


# --- Two motors on one shaft, each through a dead zone, and a load behind a cable
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


def run_pair(pair, preload, commands, push, interval):
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


# --- Two winches, two sheaves and a body in the plane: arcs from angles, directions by differences
@dataclass(frozen=True)
class Winches:
    """Left line over the top of the left sheave, right line over the top of the right one."""

    sheaves: tuple[tuple[float, float], ...]  # two centres [m]
    sheave_radius: float
    clamps: tuple[tuple[float, float], ...]  # two, at rest [m]
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
        """Whole length from the drum but for a constant, and its free part [m]; ``q``: two numbers."""
        across, up = (self.clamps[i][k] + q[k] - self.sheaves[i][k] for k in range(2))
        distance, r = hypot(across, up), self.sheave_radius
        free, slope = sqrt(distance**2 - r**2), atan2(up, across)
        if (
            i == 0
        ):  # the contact lies above the line of centres to the right: clockwise arc from the left side
            return free - r * (slope + acos(r / distance)), free + self.vertical
        slope %= 2.0 * pi
        return free + r * (slope - acos(r / distance)), free + self.vertical

    def slopes(self, i, q):
        """Change of the length with the body's place, by central differences."""
        x, y, h = *q, 1e-5
        ends = ((x + h, y), (x - h, y)), ((x, y + h), (x, y - h))
        return [(self.length(i, more)[0] - self.length(i, less)[0]) / (2.0 * h) for more, less in ends]

    def tensions(self, x, unwound):
        """Tensions, shape (2,), and slopes, shape (2, 2); x: q, v, angles, speeds."""
        q, v, angle, turn = x.reshape(4, 2).tolist()
        slopes, found = [self.slopes(i, q) for i in range(2)], [0.0, 0.0]
        for i in range(2):
            length, free = self.length(i, q)
            stretch = length + self.drum * angle[i] - unwound[i]
            rate = slopes[i][0] * v[0] + slopes[i][1] * v[1] + self.drum * turn[i]
            if stretch > 0.0:
                found[i] = max((self.rigidity * stretch + self.loss * rate) / free, 0.0)
        return np.array(found), np.array(slopes)

    def at_rest(self):
        """Tensions that carry the weight at the place of the file, and what is unwound for them."""
        slopes = np.array([self.slopes(i, (0.0, 0.0)) for i in range(2)])
        tension = np.linalg.solve(slopes.T, np.array([0.0, -self.weight]))
        lines = [self.length(i, (0.0, 0.0)) for i in range(2)]
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


def run_winches(winches, law, reference, force, interval, rtol=1e-8):
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
