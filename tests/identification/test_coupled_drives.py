"""Coupled electric drives, PRBS records: a belt, friction and a rectifying sensor against every linear model.

Structure and start values of the belt model were chosen by the residual of the training samples. The third
record of the file, at 0.5 V, is not fitted: there friction holds the belt most of the time, and the model of
the other two does not follow it. The last test says how far, and that the model's own doubts show it.
"""

import numpy as np
import pytest
from scipy import io, optimize, signal

from cabledrive.identification.chain_model import ChainModel, FreeParameter
from cabledrive.identification.fit_doubts import doubts_of
from cabledrive.identification.output_error import fit_output_error
from cabledrive.identification.record import Record
from cabledrive.identification.sensor import Sensor


def rms_of(measured, simulated):
    """Root mean square of the difference."""
    return float(np.sqrt(np.mean((measured - simulated) ** 2)))


FILE = "ced/DATAPRBS.MAT"
TRAINING = 400
START = {
    "motor inertia": 0.03,
    "pulley inertia": 0.01,
    "motor friction": 0.15,
    "pulley friction": 0.02,
    "coulomb friction": 0.3,
    "belt stiffness": 2.0,
    "belt damping": 0.01,
    "sensor lag": 0.02,
    "sensor threshold": 0.1,
}
BELT = ChainModel(
    inertias=2,
    free=(
        FreeParameter(name="motor inertia", quantity="inertia", low=1e-4, high=1.0),
        FreeParameter(name="pulley inertia", quantity="inertia", number=1, low=1e-4, high=1.0),
        FreeParameter(name="motor friction", quantity="viscous", low=1e-5, high=10.0),
        FreeParameter(name="pulley friction", quantity="viscous", number=1, low=1e-5, high=10.0),
        FreeParameter(name="coulomb friction", quantity="coulomb", low=1e-5, high=1.0),
        FreeParameter(name="belt stiffness", quantity="stiffness", low=1e-2, high=1e2),
        FreeParameter(name="belt damping", quantity="damping", low=1e-5, high=10.0),
        FreeParameter(name="sensor lag", quantity="lag", low=1e-4, high=0.2),
        FreeParameter(name="sensor threshold", quantity="threshold", low=1e-4, high=1.0),
    ),
    measured=(1,),
    given={},
    sensor=Sensor(rectified=True),
    delay=1,
    substeps=5,
)
"""Torque in volt, speed in ticks: the scale is in the inertias. The computer writes one sample late."""


@pytest.fixture(scope="module")
def all_records(shared_data):
    data = io.loadmat(shared_data(FILE), squeeze_me=True)
    return [
        Record(input=data[f"u{k}"].astype(float), output=data[f"z{k}"][:, None], interval=0.02, last=TRAINING)
        for k in (1, 2, 3)
    ]


@pytest.fixture(scope="module")
def records(all_records):
    return all_records[:2]


@pytest.fixture(scope="module")
def belt(records):
    return fit_output_error(records, BELT, START)


def test_the_belt_model_predicts_the_last_hundred_samples(records, belt, measured):
    """Fitted on the first 400 samples at 1 V and 1.5 V: at most 0.16 and 0.20 ticks/s on the last 100."""
    errors = [rms_of(r.output[TRAINING:], belt.simulated(r)[TRAINING:]) for r in records]
    measured(f"RMSE {errors[0]:.3f} and {errors[1]:.3f} ticks/s; {len(belt.values)} parameters")
    assert errors[0] <= 0.16, f"{errors}"
    assert errors[1] <= 0.20, f"{errors}"


def test_every_linear_model_is_worse(records, belt, measured):
    """Output error of orders 1 to 5, to the rectified speed and to the speed with the belt model's signs."""
    own = [rms_of(r.output[TRAINING:], belt.simulated(r)[TRAINING:]) for r in records]
    for signed in (False, True):
        errors = [linear_errors(records, belt, order, signed) for order in range(1, 6)]
        best = np.min(errors, axis=0)
        measured(f"{'signed' if signed else 'rectified'}: best RMSE {best[0]:.3f} and {best[1]:.3f} ticks/s")
        for order, linear in enumerate(errors, start=1):
            assert linear[0] > own[0], f"order {order}, signed {signed}: {linear}, belt {own}"
            assert linear[1] > own[1], f"order {order}, signed {signed}: {linear}, belt {own}"


def test_the_third_record_is_not_predicted_and_the_residual_shows_that_the_model_lacks_something(
    all_records, belt, measured
):
    """At 0.5 V, a mean of 0.49 ticks/s: the error is as large as the speed itself."""
    third = all_records[2]
    error = rms_of(third.output, belt.simulated(third))
    measured(f"third record: RMSE {error:.2f} ticks/s of a mean of {third.output.mean():.2f} ticks/s")
    assert error > 0.3, error
    doubts = dict(doubts_of(belt, all_records[:2]))
    assert "residual-not-white" in doubts, doubts


def linear_errors(records, belt, order, signed):
    """RMSE on the last samples of one linear model for both records, the better of two starts."""
    signs = [np.sign(np.diff(turning(belt, r), prepend=0.0)) if signed else 1.0 for r in records]
    targets = [r.output[:, 0] * s for r, s in zip(records, signs, strict=True)]
    inputs = [np.concatenate([[0.0], r.input[:-1]]) for r in records]
    best = None
    for start in (arx(inputs, targets, order), stable_start(order)):
        found = optimize.least_squares(
            lambda p: np.concatenate(
                [(run(p, u, order) - y)[:TRAINING] for u, y in zip(inputs, targets, strict=True)]
            ),
            start,
            x_scale="jac",
            max_nfev=200,
        )
        best = found if best is None or found.cost < best.cost else best
    shown = [run(best.x, u, order) for u in inputs]
    shown = [np.abs(y) for y in shown] if signed else shown
    return [rms_of(r.output[TRAINING:, 0], y[TRAINING:]) for r, y in zip(records, shown, strict=True)]


def turning(belt, record):
    """Angle of the pulley, whose rise has the sign of its speed."""
    plain = ChainModel(
        inertias=2, free=BELT.free[:7], measured=(1,), given={}, delay=1, substeps=BELT.substeps
    )
    values = {s.name: belt.values[s.name] for s in plain.free}
    return np.cumsum(plain.outputs(values, record)[:, 0])


def run(parameters, u, order):
    """Poles inside the unit circle whatever the coefficients: reflection coefficients by tanh."""
    denominator = np.array([1.0])
    for k in np.tanh(parameters[:order]):
        longer = np.append(denominator, 0.0)
        denominator = longer + k * longer[::-1]
    return signal.lfilter(parameters[order : 2 * order + 1], denominator, u) + parameters[-1]


def stable_start(order):
    return np.concatenate([np.full(order, -0.3), np.full(order + 1, 0.1), [0.0]])


def arx(inputs, targets, order):
    """Equation error, its poles taken over as reflection coefficients."""
    rows, right = [], []
    for u, y in zip(inputs, targets, strict=True):
        n = np.arange(order, TRAINING)
        rows.append(
            np.column_stack(
                [
                    *(-y[n - k] for k in range(1, order + 1)),
                    *(u[n - k] for k in range(order + 1)),
                    np.ones(n.size),
                ]
            )
        )
        right.append(y[n])
    found = np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0]
    roots = np.roots(np.append(1.0, found[:order]))
    roots = np.where(np.abs(roots) > 0.98, roots / np.abs(roots) * 0.98, roots)
    a, reflections = np.real(np.poly(roots)), []
    while a.size > 1:
        k = a[-1]
        reflections.append(k)
        a = ((a - k * a[::-1]) / (1 - k * k))[:-1]
    return np.concatenate([np.arctanh(reflections[::-1]), found[order : 2 * order + 1], [0.0]])
