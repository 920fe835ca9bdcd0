"""The chain in plain C, compiled for this machine, and in plain numpy: what the kernels are measured with."""

import ctypes
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from cabledrive.simulation.case import RopeRun
from cabledrive.simulation.plan import WEIGHT_W

SOURCE = Path(__file__).with_name("plain_chain.c")
COMPILE = ["gcc", "-O3", "-march=native", "-ffast-math", "-fopt-info-vec", "-fPIC", "-c"]
LOOPS = 5


def compiled() -> tuple[ctypes.CDLL, int]:
    """The library, and how many of its five inner loops the compiler says it has vectorised."""
    folder = Path(tempfile.mkdtemp(prefix="plain-chain-"))
    message = subprocess.run(
        [*COMPILE, str(SOURCE), "-o", str(folder / "chain.o")], capture_output=True, text=True, check=True
    ).stderr
    # linked without -ffast-math, which would change the arithmetic of the whole process
    subprocess.run(
        ["gcc", "-shared", str(folder / "chain.o"), "-o", str(folder / "chain.so"), "-lm"], check=True
    )
    places = {line.split(":")[1] for line in message.splitlines() if "loop vectorized" in line}
    return ctypes.CDLL(str(folder / "chain.so")), len(places)


def rim_masses(case: RopeRun) -> np.ndarray:
    """Mass that moves with drive rim and load rim, J / r^2 and the half cells [kg]."""
    return np.diag(case.mesh.mass) / [own.radius**2 for own in case.machine.pulley]


def once_each(case: RopeRun, nodes: np.ndarray) -> np.ndarray:
    """Nodes of a loop in one row, shape (..., 2 n + 1): the load pulley ends one span and begins the other."""
    return np.ascontiguousarray(np.delete(nodes, case.mesh.nodes[1, 0], axis=-1))


class InC:
    """Integrate of the C loop from the start of a case."""

    def __init__(self, library: ctypes.CDLL, case: RopeRun):
        state = case.first_state()
        self.rows = [*once_each(case, state.x), *once_each(case, state.x_t)]
        self.rows += [np.zeros(self.rows[0].size - 1) for _ in range(3)]
        drive, masses = case.machine, rim_masses(case)
        numbers = [
            case.mesh.spacing[0],
            case.grid.step,
            case.laws[0].pretension,
            case.laws[0].axial_rigidity,
            case.mesh.cells[1],
            drive.cable.transverse_damping,
            drive.layout.gravity,
            masses[0],
            masses[1],
            case.torques[0].amplitude / drive.pulley[0].radius,
            2.0 * np.pi * case.torques[0].frequency,
        ]
        self.integrate, self.segments = library.integrate, int(case.mesh.nodes[0, 1])
        self.arguments = [ctypes.c_double(number) for number in numbers]
        self.arguments += [row.ctypes.data_as(ctypes.c_void_p) for row in self.rows]

    def __call__(self, steps: int) -> None:
        self.integrate(ctypes.c_long(steps), ctypes.c_long(self.segments), *self.arguments)


class InNumpy:
    """The same step in numpy, u, v and w in one array."""

    def __init__(self, case: RopeRun):
        state, mesh = case.first_state(), case.mesh
        self.x, self.x_t, self.law, self.h, self.dt = (
            once_each(case, state.x),
            once_each(case, state.x_t),
            case.laws[0],
            mesh.spacing[0],
            case.grid.step,
        )
        damped = 0.5 * self.dt * case.machine.cable.transverse_damping
        self.keep = np.array([1.0, *[(1.0 - damped) / (1.0 + damped)] * 2])[:, None]
        self.kick = np.array([1.0, *[1.0 / (1.0 + damped)] * 2])[:, None] * self.dt / mesh.cells[1]
        self.fall = np.zeros((3, self.x.shape[1] - 2))
        self.fall[2] = self.kick[2] * once_each(case, case.plan.node[WEIGHT_W])[1:-1]
        self.n, self.masses = mesh.nodes[0, 1], rim_masses(case)
        self.torque, self.radius, self.steps = case.torques[0], case.machine.pulley[0].radius, 0

    def __call__(self, steps: int) -> None:
        x, x_t, n, dt = self.x, self.x_t, self.n, self.dt
        torque = self.torque.at((self.steps + np.arange(steps)) * dt) / self.radius
        for j in range(steps):
            slopes = (x[:, 1:] - x[:, :-1]) / self.h
            slopes[0] += 1.0
            stretch = np.sqrt(slopes[0] ** 2 + slopes[1] ** 2 + slopes[2] ** 2)
            p = (self.law.pretension + self.law.stiffness * (stretch - 1.0)) / stretch * slopes
            drive = x_t[0, 0] + dt / self.masses[0] * (p[0, 0] - p[0, -1] + torque[j])
            load = x_t[0, n] + dt / self.masses[1] * (p[0, n] - p[0, n - 1])
            x_t[:, 1:-1] = self.keep * x_t[:, 1:-1] + self.kick * (p[:, 1:] - p[:, :-1]) + self.fall
            x_t[:, n] = load, 0.0, 0.0
            x_t[0, 0] = x_t[0, -1] = drive
            x += dt * x_t
        self.steps += steps


class InNumpyByParts(InNumpy):
    """The same step in numpy as one writes the equations: u, v and w in arrays of their own."""

    def __call__(self, steps: int) -> None:
        (u, v, w), (u_t, v_t, w_t), n, dt, h = self.x, self.x_t, self.n, self.dt, self.h
        torque = self.torque.at((self.steps + np.arange(steps)) * dt) / self.radius
        keep, (kick_u, kick, _) = self.keep[1, 0], self.kick[:, 0]
        for j in range(steps):
            u_x, v_x, w_x = np.diff(u) / h, np.diff(v) / h, np.diff(w) / h
            stretch = np.sqrt((1.0 + u_x) ** 2 + v_x**2 + w_x**2)
            pull = (self.law.pretension + self.law.stiffness * (stretch - 1.0)) / stretch
            p_u, p_v, p_w = pull * (1.0 + u_x), pull * v_x, pull * w_x
            drive = u_t[0] + dt / self.masses[0] * (p_u[0] - p_u[-1] + torque[j])
            load = u_t[n] + dt / self.masses[1] * (p_u[n] - p_u[n - 1])
            u_t[1:-1] += kick_u * np.diff(p_u)
            v_t[1:-1] = keep * v_t[1:-1] + kick * np.diff(p_v)
            w_t[1:-1] = keep * w_t[1:-1] + kick * np.diff(p_w) + self.fall[2]
            u_t[0] = u_t[-1] = drive
            u_t[n], v_t[n], w_t[n] = load, 0.0, 0.0
            u += dt * u_t
            v += dt * v_t
            w += dt * w_t
        self.steps += steps
