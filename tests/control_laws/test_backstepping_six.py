"""The generated laws: held against their generator, high-precision differences and their errors' dynamics.

Compiled modules under test: cabledrive.control.backstepping_four, cabledrive.control.backstepping_six,
cabledrive.control.backstepping_kernels.
"""

from pathlib import Path
from time import perf_counter

import mpmath
import numpy as np
import pytest

import cabledrive.control.generation as generation
from cabledrive.control.backstepping import backstepping_gains, backstepping_numbers
from cabledrive.control.backstepping_chain import (
    chain_numbers,
    chain_parameters,
    chain_reference,
    chain_scales,
)
from cabledrive.control.backstepping_kernels import backstepping_command
from cabledrive.control.backstepping_six import GAINS, backstepping_six_reference
from cabledrive.control.backstepping_stability import errors_matrix, scaled_states, stability_margin
from cabledrive.control.backstepping_symbols import Backstepping
from cabledrive.control.flat_output import flat_output
from cabledrive.control.reference import flat_reference, joint_motion
from cabledrive.parameters import InputRefused
from cabledrive.trajectories import pulse
from control_chains import INTERVAL, model

CHAIN = model(4)
LAW = chain_numbers(CHAIN, 25.0, 1e-12, INTERVAL)
NOMINAL, WIDTHS = chain_parameters(CHAIN)
S1, S2 = chain_scales(CHAIN)
UNIT = np.array([1.0, 10.0, S1 * 0.01, S1 * 0.3, S2 * 1e-3, S2 * 0.05])


def sample(seed):
    """States, signals and estimates of plausible size."""
    rng = np.random.default_rng(seed)
    x = UNIT * rng.normal(size=6)
    rate = 2 * np.pi * 2.0
    y = rng.normal(size=7) * rate ** np.arange(7)
    w = rng.normal(size=9) * 0.05 * np.array([*rate ** np.arange(2, 7), *rate ** np.arange(4, 7), rate**6])
    return x, np.concatenate((y, w)), NOMINAL + WIDTHS * rng.uniform(-1, 1, 10), float(rng.normal())


def states_of(x):
    """Angles and speeds of scaled states."""
    load, twist, joint = x[0], x[2] / S1, x[4] / S2
    speeds = x[1], x[3] / S1, x[5] / S2
    return np.array([load + twist + joint, load + twist, load, sum(speeds), speeds[0] + speeds[1], speeds[0]])


@pytest.mark.parametrize("name", generation.LAWS)
def test_generating_again_gives_the_same_text(name, measured):
    path, begun = Path(generation.__file__).with_name(f"{name}.py"), perf_counter()
    text = generation.source_of(generation.LAWS[name])
    same = text == path.read_text(encoding="utf-8")
    measured(f"{len(text.splitlines())} lines in {perf_counter() - begun:.2f} s, the same: {same}")
    assert same


def test_the_derivation_does_not_swell():
    """Lines of the law: 72 for six states, 129 for eight; no expression over 100 terms."""
    counts = {
        n: len([*law.steps(), *law.adaptation()]) for n in (3, 4) for law in [Backstepping(n, True, False)]
    }
    assert counts == {3: 72, 4: 129}


@pytest.mark.kernel
@pytest.mark.parametrize("seed", range(5))
def test_compiled_law_is_its_readable_twin(seed):
    """Command to 1e-11, adaptation tau equal to the sum of phi_i z_i."""
    x, signals, estimate, friction = sample(seed)
    reference = np.array([[*signals, friction]])
    tau = np.zeros(12)
    u, z1 = backstepping_command(LAW.rows, LAW.scalars, estimate, states_of(x), reference, 0, tau)
    given = (x, signals, states_of(x)[3], np.tanh(50.0 * friction))
    readable, z, _, phi = backstepping_six_reference(LAW.rows[0], estimate, *given)
    assert u == pytest.approx(readable, rel=1e-11)
    assert z1 == pytest.approx(z[0], rel=1e-11)
    expected = np.array(phi).T @ z
    np.testing.assert_allclose(tau[:10], expected, rtol=1e-9, atol=1e-11 * np.abs(expected).max())


def rates(x, u, p, w, speed, friction):
    """Rates of the scaled states under a command, parameters p; w: known accelerations of the rows."""
    return [
        x[1],
        p[0] * x[2] + p[1] + w[0],
        x[3],
        p[2] * x[4] - p[3] * x[2] - S1 * p[1] + w[1],
        x[5],
        S2 * p[9] * u - p[4] * x[4] + p[5] * x[2] - p[6] * speed - p[7] * friction + p[8] + w[2],
    ]


def moved(x, signals, rate, step):
    """States and signals a little later."""
    chains = [signals[:7], signals[7:12], signals[12:15], signals[15:]]
    later = [[a + step * b for a, b in zip(c, [*c[1:], mpmath.mpf(0)], strict=True)] for c in chains]
    return [a + step * b for a, b in zip(x, rate, strict=True)], [a for c in later for a in c]


@pytest.mark.parametrize("seed", range(3))
def test_errors_obey_their_dynamics_to_eleven_digits(seed, measured):
    """z' = A z - Phi^T p~ by central differences with 60 digits, true parameters unlike the estimates.

    Every partial derivative of every virtual control enters; one wrong term shows at once.
    """
    with mpmath.workdps(60):
        x, signals, estimate, friction = sample(seed)
        numbers = [[mpmath.mpf(float(v)) for v in a] for a in (LAW.rows[0], estimate, x, signals)]
        gains, p, x, signals = numbers
        truth = [mpmath.mpf(float(v)) for v in sample(seed + 100)[2]]
        speed, friction = mpmath.mpf(states_of(np.array(x, float))[3]), mpmath.mpf(friction)
        u, z, _, phi = backstepping_six_reference(gains, p, x, signals, speed, friction)
        w = (signals[7], signals[12], signals[15])
        rate, step = rates(x, u, truth, w, speed, friction), mpmath.mpf(10) ** -20

        def errors(sign):
            later = moved(x, signals, rate, sign * step)
            return backstepping_six_reference(gains, p, *later, speed, friction)[1]

        matrix = errors_matrix(LAW, np.array(p, float), 6)
        after, before, off = errors(1), errors(-1), []
        for i in range(6):
            found = (after[i] - before[i]) / (2 * step)
            row = [mpmath.mpf(matrix[i, j]) * z[j] for j in range(6)]
            row += [-phi[i][m] * (p[m] - truth[m]) for m in range(10)]
            off.append(float(abs(found - sum(row)) / max(abs(term) for term in row)))
        measured(f"within {max(off):.1e} of the largest term of each row")
        assert max(off) <= 1e-11, f"observed {off}"


def test_along_the_reference_no_error_arises():
    """The reference with its dampers solves the nominal plant: u of the law is that of the flat output."""
    time = np.asarray(INTERVAL * np.arange(2500), dtype=np.float64)
    wanted = pulse(0.8, 0.5, 0.0)(time, 6)
    reference = chain_reference(CHAIN, wanted, INTERVAL)
    flat = flat_output(CHAIN)
    rows = flat_reference(flat, wanted, INTERVAL)
    states, elastic = joint_motion(flat, rows)
    for k in (300, 800, 1700):
        u, z1 = backstepping_command(
            LAW.rows, LAW.scalars, NOMINAL.copy(), states[k], reference, k, np.zeros(12)
        )
        friction = CHAIN.coulomb[0] * np.tanh(50.0 * rows[k, -2]) - CHAIN.offsets[0]
        needed = elastic[k] + CHAIN.inertias[0] * rows[k, -1] + CHAIN.viscous[0] * rows[k, -2] + friction
        assert abs(z1) < 1e-6
        assert u == pytest.approx(needed, abs=2e-4), f"sample {k}: {u}, {needed}"


def test_poles_of_the_errors_are_the_designed_ones():
    """With cross gains of 1 against 157^2 the six poles stay at 25 Hz."""
    hertz = np.abs(np.linalg.eigvals(errors_matrix(LAW, NOMINAL, 6))) / (2 * np.pi)
    np.testing.assert_allclose(hertz, 25.0, rtol=0.03)
    assert len(GAINS) == 12


def test_condition_holds_without_adaptation_and_fails_with_it():
    """D_z at rest: positive for gamma = 0; at the gamma that helps, negative over the motion."""
    time = np.asarray(INTERVAL * np.arange(2500), dtype=np.float64)
    wanted = pulse(0.8, 0.5, 0.0)(time, 6)
    reference = chain_reference(CHAIN, wanted, INTERVAL)
    states = joint_motion(flat_output(CHAIN), flat_reference(flat_output(CHAIN), wanted, INTERVAL))[0]
    still = chain_numbers(CHAIN, 25.0, 0.0, INTERVAL)
    margins = [stability_margin(law, NOMINAL, states[900], reference[900]) for law in (still, LAW)]
    assert margins[0] == pytest.approx(2 * np.pi * 25.0, rel=0.02)
    assert margins[1] < 0.0, f"observed {margins}"


def test_margin_of_four_states_is_that_of_the_errata():
    """The matrix of the printed law without adaptation: its smallest eigenvalue is its bandwidth."""
    law = backstepping_numbers(model(3), backstepping_gains(adaptation=0.0), INTERVAL)
    margin = stability_margin(law, law.learning[0], np.zeros(4), np.zeros(5))
    assert margin == pytest.approx(2 * np.pi * 10.5, rel=1e-9)


def test_scaled_states_are_those_of_the_law():
    x = sample(3)[0]
    np.testing.assert_allclose(scaled_states(LAW, states_of(x)), x, rtol=1e-9)


@pytest.mark.parametrize("choices", [(-1.0, 0.0), (float("nan"), 0.0), (25.0, -1.0)])
def test_gains_that_cannot_be_are_refused(choices):
    with pytest.raises(InputRefused):
        chain_numbers(CHAIN, *choices, INTERVAL)


def test_model_3_has_too_few_inertias():
    with pytest.raises(InputRefused, match="Model 4"):
        chain_parameters(model(3))
