"""Small motions of the full loop ring at the certified natural frequencies."""

from dataclasses import replace

import numpy as np
import pytest
from kernel_cases import chain_matrices, heard
from scipy.linalg import eigh
from scipy.special import ellipk

from cabledrive.mechanics.cable_laws import cable_law
from cabledrive.mechanics.mesh import mesh_of
from cabledrive.modal import modes
from cabledrive.parameters.drive_file import load_drive
from cabledrive.parameters.drive_parts import Carriage
from cabledrive.simulation import Pluck, Recording, Scheme, Start, simulate

LOOP = load_drive("dissertation-2").listed
WEIGHTLESS = replace(LOOP, layout=replace(LOOP.layout, gravity=0.0))
CARRIED = replace(
    WEIGHTLESS, carriage=(Carriage(mass=5e-4, position=0.3), Carriage(mass=4e-4, position=0.4, span="lower"))
)
MOTORED = replace(load_drive("dissertation-3").listed, layout=WEIGHTLESS.layout)
RUNNERS = {
    "loop": WEIGHTLESS,
    "line": replace(WEIGHTLESS, kind="line"),
    "carriages": CARRIED,
    "motor": MOTORED,
    "motor held by a spring": replace(MOTORED, motor=replace(MOTORED.motor, holding_stiffness=20.0)),
    "rigid motor held by a spring": replace(
        MOTORED, motor=replace(MOTORED.motor, holding_stiffness=20.0, joint_stiffness=None)
    ),
}


def frictionless(drive):
    none = {"viscous_friction": 0.0, "coulomb_friction": 0.0, "joint_damping": 0.0, "offset_torque": 0.0}
    motor = drive.motor and replace(drive.motor, **none)
    return replace(
        drive,
        cable=replace(drive.cable, transverse_damping=0.0, axial_damping=0.0),
        pulley=tuple(replace(p, viscous_friction=0.0, coulomb_friction=0.0) for p in drive.pulley),
        motor=motor,
    )


def certified(drive, kind, count):
    found = [m for m in modes(drive, count=count).modes if m.kind == kind and m.plane != "v"]
    return np.sort(np.repeat([m.frequency for m in found], [m.multiplicity for m in found]))


def frequencies_of_the_scheme(drive, segments, step, kind):
    """What leapfrog makes of the chain's own frequencies: sin(w step / 2) = step sqrt(eigenvalue) / 2."""
    mesh, law = mesh_of(drive.machine, segments), cable_law(drive.cable)
    stiffness = law.stiffness if kind == "longitudinal" else law.pretension
    springs, mass = chain_matrices(mesh, np.full(2, stiffness))
    if kind == "transverse":
        sways = np.flatnonzero(np.concatenate([mesh.sways[a + 1 : b] for a, b in mesh.nodes]))
        springs, mass = springs[np.ix_(sways, sways)], mass[np.ix_(sways, sways)]
    eigenvalues = np.maximum(eigh(springs, mass, eigvals_only=True), 0.0)
    lowest = np.sqrt(eigenvalues[eigenvalues > 1.0][:12])
    return np.arcsin(0.5 * step * lowest) / (np.pi * step)


def small_motion(drive, segments, duration):
    """A tiny random bump in every direction, and the pulleys set turning: all modes at once."""
    rng = np.random.default_rng(4)
    profile = np.concatenate(([0.0], 1e-9 * rng.standard_normal(9), [0.0]))
    held = [c.position for c in drive.carriage if c.guided and c.span == "upper"]

    def bump(x):
        shape = np.interp(x, np.linspace(0.0, drive.pulley_distance, 11), profile)
        for place in held:
            shape = shape * (x - place * (1.0 + drive.cable.prestrain)) ** 2
        return shape

    plucks = tuple(
        Pluck(plane=plane, shape=bump, height=h) for plane, h in (("u", 1.0), ("v", 1e2), ("w", 1e2))
    )
    return simulate(
        drive,
        duration,
        start=Start(plucks=plucks, drive_speed=1e-3, load_speed=-1e-3),
        scheme=Scheme(segments=segments),
        recording=Recording(rate=40_000.0, probes=(("upper", 0.37), ("upper", 0.81))),
    )


@pytest.mark.parametrize("kind", ["longitudinal", "transverse"])
@pytest.mark.parametrize("runner", ["loop", "motor", "motor held by a spring"])
def test_small_motions_ring_at_the_scheme_s_own_frequencies(runner, kind, measured):
    """First five of each kind, heard in a run of the exact law: within 0.05 Hz of the discrete spectrum."""
    drive = frictionless(RUNNERS[runner])
    result = small_motion(drive, 40, 1.0)
    probe = result.probe(2)[:, 0 if kind == "longitudinal" else 2]
    slope = np.polyval(np.polyfit(result.time, probe, 1), result.time) if kind == "longitudinal" else 0.0
    expected = np.unique(np.round(frequencies_of_the_scheme(drive, 40, result.step, kind), 6))[:5]
    found = heard(probe - slope, result.time[1], expected)
    measured(f"within {np.max(np.abs(found - expected)):.2g} Hz")
    np.testing.assert_allclose(found, expected, atol=0.05, err_msg=f"{runner}, {kind}")


@pytest.mark.parametrize("kind", ["longitudinal", "transverse"])
@pytest.mark.parametrize("runner", RUNNERS)
def test_the_scheme_s_frequencies_converge_to_the_certified_ones(runner, kind, measured):
    """First five of each kind, with order two; at n = 160 within 1e-3."""
    drive = frictionless(RUNNERS[runner])
    exact = certified(drive, kind, 20)[:5]
    counts = np.array([40, 80, 160])
    step = simulate(drive, 1e-4, scheme=Scheme(segments=40)).step
    errors = np.array(
        [
            np.abs(frequencies_of_the_scheme(drive, int(n), step * 40 / n, kind)[:5] / exact - 1.0)
            for n in counts
        ]
    )
    seen = errors[-2] > 1e-7  # round-off of the eigenvalue solver, 1e-8 to 3e-8, hides the rest
    orders = np.log2(errors[:-1] / np.maximum(errors[1:], 1e-16))[-1, seen]
    range_of_orders = f"; order {orders.min():.3f} to {orders.max():.3f}" if seen.any() else ""
    measured(f"relative error {np.max(errors[-1]):.1e} at n = 160{range_of_orders}")
    assert np.max(errors[-1]) < 1e-3, f"errors {errors[-1]}"
    np.testing.assert_allclose(orders, 2.0, atol=0.1, err_msg=f"errors\n{errors}")


def test_the_plucked_drive_of_the_dissertation_sounds_at_81_7_hz(measured):
    """Both spans plucked unequally, the cable damped: highest peak of the load pulley's spectrum.

    Printed: 81.6 Hz. At the tension of 5 N the cable itself pulls at twice its frequency, 100.8 Hz, until it
    has died away.
    """
    drive = replace(LOOP, cable=replace(LOOP.cable, transverse_damping=5.0))
    result = simulate(
        drive,
        2.0,
        start=Start(plucks=(Pluck(height=2e-3), Pluck(height=1e-3, span="lower"))),
        scheme=Scheme(segments=40),
    )
    angle = result.load_angle - np.polyval(np.polyfit(result.time, result.load_angle, 1), result.time)
    spectrum = np.abs(np.fft.rfft(angle * np.hanning(angle.size)))
    loudest = np.argmax(spectrum) / (angle.size * result.time[1])
    found = heard(angle, result.time[1], [loudest])[0]
    measured(f"{found:.3f} Hz")
    assert found == pytest.approx(81.74, abs=0.05), f"{found:.3f} Hz"


# --- A pinned string in its first mode: the chain against the one-mode string of Kirchhoff and Carrier
PINNED = replace(
    LOOP,
    kind="line",
    layout=replace(LOOP.layout, gravity=0.0),
    pulley=tuple(replace(pulley, fixed=True) for pulley in LOOP.pulley),
)
KAPPA = np.pi / PINNED.pulley_distance
OMEGA = KAPPA * PINNED.cable.transverse_wave_speed
RIGIDITY_OVER_TENSION = PINNED.cable.axial_rigidity / PINNED.cable.pretension  # 221.5
ALPHA = OMEGA**2 * RIGIDITY_OVER_TENSION / 4.0 * KAPPA**2


def planar(amplitude):
    """Angular frequency of q'' + OMEGA^2 q + ALPHA q^3 = 0."""
    square = OMEGA**2 + ALPHA * amplitude**2
    return np.pi * np.sqrt(square) / (2.0 * ellipk(ALPHA * amplitude**2 / (2.0 * square)))


def whirling(amplitude):
    """The same in a circle."""
    return np.sqrt(OMEGA**2 + ALPHA * amplitude**2)


def of_the_chain(amplitude, whirls):
    """Angular frequency of the midpoint, from the phase between the two halves of a run."""
    kick = Pluck(height=amplitude * whirling(amplitude), plane="v", shape="half-sine")
    result = simulate(
        PINNED,
        0.5,
        start=Start(plucks=(Pluck(height=amplitude, shape="half-sine"),), kicks=(kick,) if whirls else ()),
        scheme=Scheme(segments=50),
        recording=Recording(rate=4000.0),
    )
    half = result.time.size // 2
    turned = result.midpoint()[:, 2] * np.exp(-1j * OMEGA * result.time)
    first, second = (np.sum(np.hanning(half) * turned[k * half : (k + 1) * half]) for k in (0, 1))
    return OMEGA + np.angle(second / first) / result.time[half]


@pytest.mark.parametrize(("whirls", "one_mode"), [(False, planar), (True, whirling)])
def test_the_distance_to_the_one_mode_string_vanishes_with_the_square_of_the_amplitude(
    whirls, one_mode, measured
):
    """EA / T0 = 221.5, amplitudes 1, 2, 4 mm on a metre: shifts of frequency agree to 0.3 % of themselves."""
    amplitudes = np.array([1e-3, 2e-3, 4e-3])
    resting = of_the_chain(1e-7, whirls)
    shift = np.array([of_the_chain(a, whirls) for a in amplitudes]) / resting - 1.0
    expected = np.array([one_mode(a) for a in amplitudes]) / OMEGA - 1.0
    distance = np.abs(shift - expected)
    order = np.polyfit(np.log(amplitudes), np.log(distance), 1)[0]
    measured(f"shift of frequency within {np.max(distance / expected):.1e} of itself, order {order:.2f}")
    assert np.max(distance / expected) < 3e-3, f"{distance / expected}"
    assert order == pytest.approx(2.0, abs=0.1), f"order {order:.2f}, distances {distance}"
