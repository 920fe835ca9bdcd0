"""A pinned string after a half-sine pluck, in plain terms that every package can take, and in each of them.

The string: EA, mass per unstretched metre and pretension of `dissertation-2`, both ends held, no weight, no
damping, exact geometry. Each function integrates it with n pieces and returns the displacement at midspan at the
times asked for. Packages that are not installed raise ImportError.
"""

import tempfile
from itertools import pairwise
from pathlib import Path

import numpy as np

import cabledrive as cd
from cabledrive.simulation import Pluck, Recording, Scheme, Start
from cabledrive.simulation.case import RopeRun, case_of

DRIVE = cd.load_drive(
    "dissertation-2",
    overrides=["kind=line", "layout.gravity=0", "pulley.0.fixed=true", "pulley.1.fixed=true"],
).two_pulleys
RIGIDITY, MASS, PRETENSION = DRIVE.cable.axial_rigidity, DRIVE.cable.mass_per_length, DRIVE.cable.pretension
STRETCH = 1.0 + DRIVE.cable.prestrain
LENGTH = DRIVE.pulley_distance  # pretensioned
HEIGHT = 5e-3
DURATION, RATE = 0.05, 2_000.0
TIMES = np.arange(1, round(DURATION * RATE) + 1) / RATE


def largest_step(pieces: int) -> float:
    """Of leapfrog, s."""
    return LENGTH / pieces / DRIVE.cable.axial_wave_speed


def dividing(step: float) -> float:
    """The longest step up to this one that divides the time between records."""
    return float(1.0 / RATE / np.ceil(1.0 / RATE / step))


def pluck(x: np.ndarray) -> np.ndarray:
    return HEIGHT * np.sin(np.pi * x / LENGTH)


def chain_case(pieces: int) -> RopeRun:
    return case_of(
        DRIVE.machine,
        DURATION,
        start=Start(plucks=(Pluck(height=HEIGHT, shape="half-sine"),)),
        scheme=Scheme(segments=pieces),
        recording=Recording(rate=RATE),
    )


def in_mujoco(pieces: int):
    """Point masses on two slides each, joined by tendons that are linear springs; returns its run."""
    import mujoco

    h, step = LENGTH / pieces, dividing(0.9 * largest_step(pieces))
    stiffness = RIGIDITY * STRETCH / h
    mass = MASS / STRETCH * h
    bodies, tendons = [], []
    for i in range(pieces + 1):
        moving = (
            '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>' if 0 < i < pieces else ""
        )
        bodies.append(
            f'<body pos="{i * h!r} 0 0">{moving}<inertial pos="0 0 0" mass="{mass!r}" '
            f'diaginertia="1e-9 1e-9 1e-9"/><site name="s{i}"/></body>'
        )
    for i in range(pieces):
        tendons.append(
            f'<spatial stiffness="{stiffness!r}" springlength="{h - PRETENSION / stiffness!r}">'
            f'<site site="s{i}"/><site site="s{i + 1}"/></spatial>'
        )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{step!r}" gravity="0 0 0" integrator="Euler">'
        '<flag contact="disable" constraint="disable" eulerdamp="disable"/></option>'
        f"<worldbody>{''.join(bodies)}</worldbody><tendon>{''.join(tendons)}</tendon></mujoco>"
    )
    data = mujoco.MjData(model)
    per_record, middle = round(1.0 / RATE / step), 2 * (pieces // 2 - 1) + 1

    def run() -> np.ndarray:
        mujoco.mj_resetData(model, data)
        data.qpos[1::2] = pluck(h * np.arange(1, pieces))
        mujoco.mj_forward(model, data)
        data.qvel[:] = -0.5 * step * data.qacc  # its Euler step is leapfrog from half a step before
        found = np.empty(TIMES.size)
        for k in range(TIMES.size):
            mujoco.mj_step(model, data, nstep=per_record)
            found[k] = data.qpos[middle]
        return found

    return run


def in_moordyn(pieces: int):
    """A mooring line in a sea without density, its nodes put on the half-sine; returns its run."""
    import moordyn

    step = dividing(1.2 * largest_step(pieces))
    height = 100.0  # above the sea
    text = f"""--------------------- MoorDyn input ------------------------------
----------------------- LINE TYPES ------------------------------------------
TypeName   Diam    Mass/m     EA     BA/-zeta    EI      Cd     Ca     CdAx   CaAx
(name)     (m)     (kg/m)     (N)    (N-s/-)     (N-m^2) (-)    (-)    (-)    (-)
cable      1e-3    {MASS!r}  {RIGIDITY!r}  0.0   0.0     0.0    0.0    0.0    0.0
----------------------- POINTS ----------------------------------------------
ID  Attachment  X     Y     Z    M    V    CdA   CA
(#) (-)         (m)   (m)   (m)  (kg) (m^3) (m^2) (-)
1   Fixed       0.0   0.0   {height}  0  0  0  0
2   Fixed       {LENGTH!r}   0.0   {height}  0  0  0  0
----------------------- LINES -----------------------------------------------
ID  LineType  AttachA  AttachB  UnstrLen   NumSegs  Outputs
(#) (name)    (#)      (#)      (m)        (-)      (-)
1   cable     1        2        {LENGTH / STRETCH!r}  {pieces}  -
----------------------- OPTIONS -----------------------------------------------
0        writeLog
{step!r} dtM
RK4      tScheme
0.0      g
1e-9     WtrDnsty
10.0     WtrDpth
0.0      TmaxIC
--------------------- need this line ------------------
"""
    folder = Path(tempfile.mkdtemp(prefix="pinned-string-"))
    (folder / "string.txt").write_text(text)
    system = moordyn.Create(str(folder / "string.txt"))
    moordyn.SetVerbosity(system, moordyn.LEVEL_NONE)
    moordyn.Init(system, [], [])
    line = moordyn.GetLine(system, 1)
    straight = np.array([moordyn.GetLineNodePos(line, i) for i in range(pieces + 1)])
    state = np.frombuffer(moordyn.Serialize(system), dtype=np.uint64)
    x = straight[1:-1, 0]
    plucked = straight[1:-1].copy()
    plucked[:, 2] += pluck(x)
    still = np.zeros_like(plucked)
    for columns in ((), (still,)):  # positions in the line; positions and velocities in the time scheme
        old, new = (np.hstack((places, *columns)).ravel() for places in (straight[1:-1], plucked))
        state = _replaced(state, old, new)

    def run() -> np.ndarray:
        moordyn.Deserialize(system, state.tobytes())
        found = np.empty(TIMES.size)
        time = 0.0
        for k in range(TIMES.size):
            time = moordyn.Step(system, [], [], time, 1.0 / RATE) or TIMES[k]
            found[k] = moordyn.GetLineNodePos(line, pieces // 2)[2] - height
        return found

    return run


def _replaced(words: np.ndarray, old: np.ndarray, new: np.ndarray) -> np.ndarray:
    """Every place in a sequence of words that holds one sequence of doubles, filled with another."""
    values, found = words.view(np.float64).copy(), 0
    for k in range(values.size - old.size + 1):
        if values[k] == old[0] and np.array_equal(values[k : k + old.size], old):
            values[k : k + old.size] = new
            found += 1
    if not found:
        raise RuntimeError("MoorDyn keeps its nodes in another order than before")
    return values.view(np.uint64)


def in_exudyn(pieces: int):
    """Cubic elements without bending stiffness, integrated by the trapezoidal rule; returns its run."""
    import exudyn as exu
    from exudyn import utilities as item

    h = LENGTH / STRETCH / pieces
    x = h * np.arange(pieces + 1)
    w, w_x = pluck(STRETCH * x), np.pi * HEIGHT / (h * pieces) * np.cos(np.pi * x / (h * pieces))
    element = {"length": h, "massPerLength": MASS, "bendingStiffness": 0.0, "axialStiffness": RIGIDITY}
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = TIMES.size * pieces  # per record as many as elements
    settings.timeIntegration.endTime = DURATION
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = 1.0 / RATE

    def made():
        container = exu.SystemContainer()
        system = container.AddSystem()
        nodes = [
            system.AddNode(
                item.Point2DS1(
                    referenceCoordinates=[x[i], 0.0, 1.0, 0.0],
                    initialCoordinates=[(STRETCH - 1.0) * x[i], w[i], STRETCH - 1.0, w_x[i]],
                )
            )
            for i in range(pieces + 1)
        ]
        for pair in pairwise(nodes):
            system.AddObject(item.Cable2D(nodeNumbers=list(pair), **element))
        ground = item.MarkerNodeCoordinate(nodeNumber=system.AddNode(item.NodePointGround()), coordinate=0)
        held = system.AddMarker(ground)
        for node, place in ((nodes[0], 0.0), (nodes[-1], LENGTH - LENGTH / STRETCH)):
            for coordinate, offset in ((0, place), (1, 0.0)):
                end = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
                system.AddObject(item.CoordinateConstraint(markerNumbers=[held, end], offset=offset))
        middle = system.AddSensor(
            item.SensorNode(
                nodeNumber=nodes[pieces // 2], outputVariableType=exu.OutputVariableType.Displacement,
                storeInternal=True, writeToFile=False,
            )
        )  # fmt: skip
        system.Assemble()
        return container, system, middle

    def run() -> np.ndarray:
        _container, system, middle = made()
        system.SolveDynamic(settings, solverType=exu.DynamicSolverType.TrapezoidalIndex2)
        message = system.GetSensorStoredData(middle)
        return np.interp(TIMES, message[:, 0], message[:, 2])

    return run


def in_pyelastica(pieces: int):
    """A Cosserat rod, the thinner the more elements, so that its bending vanishes as well; returns its run."""
    import elastica as ea

    radius = 0.02 / pieces

    class Held(ea.BaseSystemCollection, ea.Constraints):
        pass

    area = np.pi * radius**2
    h = LENGTH / pieces
    stretch = 1.0 + PRETENSION / (RIGIDITY * STRETCH)  # its tension is E A (1 - 1/e)
    modulus = RIGIDITY * STRETCH * stretch / area
    wave_speed = np.sqrt(modulus * area * STRETCH / MASS)
    step = dividing(0.5 * min(largest_step(pieces), radius / wave_speed))

    def made():
        system = Held()
        rod = ea.CosseratRod.straight_rod(
            pieces, np.zeros(3), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]), LENGTH, radius,
            MASS / STRETCH / area, youngs_modulus=modulus, shear_modulus=modulus / 2.6,
        )  # fmt: skip
        rod.rest_lengths[:] = h / stretch
        rod.rest_voronoi_lengths[:] = h / stretch
        rod.position_collection[2] = pluck(rod.position_collection[0])
        tangents = np.diff(rod.position_collection, axis=1)
        tangents /= np.linalg.norm(tangents, axis=0)
        rod.director_collection[2] = tangents
        rod.director_collection[1] = np.cross(tangents.T, rod.director_collection[0].T).T
        system.append(rod)
        system.constrain(rod).using(ea.FixedConstraint, constrained_position_idx=(0, -1))
        system.finalize()
        return system, rod

    stepper, per_record = ea.PositionVerlet(), round(1.0 / RATE / step)

    def run() -> np.ndarray:
        system, rod = made()
        found, time = np.empty(TIMES.size), np.float64(0.0)
        for k in range(TIMES.size):
            for _ in range(per_record):
                time = stepper.step(system, time, step)
            found[k] = rod.position_collection[2, pieces // 2]
        return found

    return run
