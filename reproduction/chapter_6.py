"""Sections 6.1 and 6.2: the pulse, the drive of the rig and its reduced models; Table 6.3."""

from math import pi, sqrt

import numpy as np

from cabledrive.reduction.lumped_chain import lumped_model, natural_frequencies_of, speed_response
from cabledrive.rig import Motion
from cabledrive.trajectories.limits import derivative_jump, rise_coefficients
from reproduction.chapter_3 import printed_data
from reproduction.chapter_4 import CLOSE, measured_response
from reproduction.drives import packaged
from reproduction.items import Found, Outcome
from reproduction.panel import panel


def figure_6_1(quick: bool) -> Outcome:
    """Fig. 6.1: the pulse, and the polynomial behind it: the five rows of (6.3) for unit time."""
    motion, coefficients = Motion(order=9), rise_coefficients(9)
    time = np.linspace(0.0, 2 * (motion.rise + motion.dwell), 801)
    powers, rows = np.arange(5, 10), [np.ones(5)]
    for order in range(4):
        rows.append(rows[-1] * (powers - order))
    solved = np.linalg.solve(rows, [1.0, 0.0, 0.0, 0.0, 0.0])
    off = float(np.max(np.abs(solved - coefficients[5:]) / np.abs(solved)))
    jump = float(abs(derivative_jump(9)))
    found: Found = {"coefficients": ", ".join(f"{value:.0f}" for value in coefficients[5:]), "off": off}
    found |= {"jump": jump, "angle": motion.angle, "rise": motion.rise, "dwell": motion.dwell}
    found |= {"section_6_1_coefficients": off < 1e-9, "section_6_1_smooth": jump == 0.0}
    curve = ("reference", time, np.degrees(motion.trajectory(time)[0]))
    title = "Single pulse of ninth order; angle, rise and dwell chosen"
    return found, [panel("Fig. 6.1", title, "time [s] | angle [deg]", curve)]


def tables_6_1_and_6_2(quick: bool) -> Outcome:
    """Tables 6.1 and 6.2 beside the packaged drive, and what they say of the cable's spring."""
    drive = packaged("dissertation-3")
    motor, lumped = drive.motor, drive.lumped
    assert motor is not None
    assert lumped is not None
    pulley = drive.drive_pulley.inertia
    first = {
        "j1": motor.inertia + pulley,
        "j11": motor.inertia,
        "j12": pulley,
        "j2": drive.load_pulley.inertia,
    }
    first |= printed_data(drive) | {"stiffness": drive.cable.axial_rigidity / drive.span_length}
    second = {"k": lumped.cable_stiffness, "bc": lumped.cable_damping}
    second |= {"km": motor.joint_stiffness, "bm": motor.joint_damping}
    found = {f"table_6_1_{key}": value for key, value in first.items()}
    return found | {f"table_6_2_{key}": value for key, value in second.items()}, []


def figure_6_3(quick: bool) -> Outcome:
    """Fig. 6.3: response of Models 3 and 4, and the measured one by the virtual rig."""
    chains = {number: lumped_model(packaged("dissertation-3"), number) for number in (3, 4)}
    hertz = natural_frequencies_of(chains[4]) / (2 * pi)
    frequency, response, off = measured_response(chains[4])
    found = {"section_6_2_3_7_hz": hertz[0], "section_6_2_3_120_hz": hertz[1]}
    found |= {"off": 100 * off, "figure_6_3": off < CLOSE}
    grid = np.geomspace(1.0, 500.0, 400)
    theory = ((f"Model {n}", grid, np.abs(speed_response(c, 2 * pi * grid))) for n, c in chains.items())
    title = "Motor speed over compensated torque: virtual rig, Models 3 and 4"
    axes = "frequency [Hz] | speed per torque [rad/(N m s)]"
    return found, [
        panel("Fig. 6.3", title, axes, ("virtual rig", frequency, np.abs(response)), *theory, log="xy")
    ]


def table_6_3(quick: bool) -> Outcome:
    """Table 6.3: estimates and bounds by their definitions."""
    drive = packaged("dissertation-3")
    motor, lumped = drive.motor, drive.lumped
    assert motor is not None
    assert lumped is not None
    assert lumped.cable_stiffness is not None
    first, second = motor.inertia + drive.drive_pulley.inertia, drive.load_pulley.inertia
    stiffness = 2 * lumped.cable_stiffness * drive.drive_pulley.radius**2
    beta = stiffness / second
    values = {"p1": 1.0, "p3": stiffness / first + beta, "p7": 1.0 / first}
    values |= {"p4": motor.viscous_friction * beta / first, "p5": motor.coulomb_friction * beta / first}
    found = {"table_6_3_beta_n": beta}
    for name, value in values.items():
        share = 0.05 if name == "p1" else 0.03
        found |= {f"table_6_3_{name}": value}
        found |= {f"table_6_3_{name}_min": value * (1 - share), f"table_6_3_{name}_max": value * (1 + share)}
    ring = sqrt(beta * (1 + second / first)) / (2 * pi)
    return found | {"anti": sqrt(beta) / (2 * pi), "ring": ring}, []
