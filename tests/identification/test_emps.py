"""The EMPS benchmark: the authors' figures by their recipe, ours by nothing but the log."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import io, optimize, signal
from scipy.interpolate import CubicSpline

from cabledrive.identification.axis.axis import AxisOptions, axis_of
from cabledrive.identification.axis.equation import FrictionModel
from cabledrive.identification.chain_fit import ChainModel, FreeParameter, Record, fit_output_error
from cabledrive.identification.logs.log import ColumnMap, with_choices
from cabledrive.identification.logs.reading import read_log
from oracles.axis_plant import move, parameters

FILE = "emps/DATA_EMPS.mat"
COLUMNS = with_choices(ColumnMap(), ["time=t", "position=qm", "force=vir:N*gtau"])
PUBLISHED = {
    "mass": 95.1089,
    "viscous_friction": 203.5034,
    "coulomb_friction": 20.3935,
    "offset_force": 3.1648,
}
BOUNDS = {"mass": 0.01, "viscous_friction": 0.02, "coulomb_friction": 0.02, "offset_force": 0.05}


def recipe_rows(position, force):
    """The authors' rows: two differences, every column decimated by a Chebyshev filter both ways."""
    v = recipe_velocity(position)
    columns = np.column_stack([np.gradient(v, 1e-3), v, np.sign(v), np.ones_like(v)])
    rows, low = (columns[49:], force[49:]), signal.cheby1(8, 0.05, 0.08)
    return [signal.filtfilt(*low, one, axis=0, padlen=24)[1::10] for one in rows]


def published(position, force):
    """Values, deviations, condition, norm of the residual, that over the force's, its deviation, rows."""
    w, y = recipe_rows(position, force)
    values = np.linalg.lstsq(w, y, rcond=None)[0]
    rest, norm = y - w @ values, np.linalg.norm(y - w @ values)
    spread = np.std(rest, ddof=1)
    deviations = spread * np.sqrt(np.diag(np.linalg.inv(w.T @ w)))
    return values, deviations, np.linalg.cond(w), norm, norm / np.linalg.norm(y), spread, y.size


@pytest.fixture
def log(shared_data):
    return read_log(shared_data(FILE), COLUMNS)


def test_the_authors_recipe_gives_every_printed_digit(log, measured):
    values, deviations, *rest = published(log.channel("position"), log.channel("force"))
    measured(" ".join(f"{x:.4f}" for x in (*values, *deviations, *rest)))
    assert [f"{x:.4f}" for x in values] == ["95.1089", "203.5034", "20.3935", "-3.1648"]
    assert [f"{x:.4f}" for x in deviations] == ["0.1085", "1.1460", "0.1012", "0.0444"]
    assert [f"{x:.4f}" for x in rest[:2]] == ["25.9883", "108.7569"]
    assert (f"{100 * rest[2]:.4f}", f"{rest[3]:.4f}", rest[4]) == ("4.0834", "2.1843", 2480)


def test_our_defaults_are_near_the_published_figures(log, measured):
    """With no options: bandwidth, dead zone and segments come from the data."""
    found = axis_of([log], AxisOptions()).regressed()
    deviations = {name: found[name] / value - 1 for name, value in PUBLISHED.items()}
    measured(", ".join(f"{name} {100 * off:+.2f} %" for name, off in deviations.items()))
    assert all(abs(deviations[name]) < BOUNDS[name] for name in BOUNDS), deviations
    assert found.identifiable
    for name, value in PUBLISHED.items():
        assert found.parameters[name].low < value < found.parameters[name].high


def test_asymmetric_friction_beside_an_offset_is_not_identifiable_and_the_direction_is_named(log, measured):
    options = AxisOptions(friction=FrictionModel(kind="asymmetric-offset"))
    found = axis_of([log], options).regressed()
    measured("; ".join(found.unidentifiable) or "not refused")
    assert not found.identifiable
    words = found.unidentifiable[0]
    assert "coulomb friction (positive speed), coulomb friction (negative speed), offset force" in words
    assert "are not identifiable separately" in words
    for name in ("coulomb_friction_positive", "coulomb_friction_negative", "offset_force"):
        assert np.isnan(found[name])
        assert found.parameters[name].high == float("inf")
        assert found.as_dict()["parameters"][name]["value"] is None
    assert found["mass"] == pytest.approx(95.1, rel=0.01)


def test_asymmetric_friction_without_an_offset_is_found(log):
    found = axis_of([log], AxisOptions(friction=FrictionModel(kind="asymmetric"))).regressed()
    assert found["viscous_friction_positive"] == pytest.approx(166.7, rel=0.02)
    assert found["viscous_friction_negative"] == pytest.approx(240.4, rel=0.02)


@pytest.mark.parametrize("filter_", ["causal", "ideal"])
def test_the_other_filters_agree_within_their_bounds(log, filter_):
    found = axis_of([log], AxisOptions(filter=filter_)).regressed()
    deviations = {name: found[name] / value - 1 for name, value in PUBLISHED.items()}
    assert all(abs(deviations[name]) < 2 * BOUNDS[name] for name in BOUNDS), deviations


def test_the_identified_model_in_its_loop_follows_the_measured_motion(log, shared_data, measured):
    """At most 0.02 and 0.25 %; published: position 0.013752 %, velocity 0.22911 %.

    The record begins in motion, so the simulation begins with the measured position and speed. The velocity
    is that of the authors' recipe, Butterworth of order 4 at 100 Hz forwards and backwards and a central
    difference, over all samples; the difference of the raw positions beside it.
    """
    data = io.loadmat(shared_data(FILE), squeeze_me=True)
    found = axis_of([log], AxisOptions()).regressed()
    record, gain = log.channel("position"), float(data["gtau"]) * float(data["kv"])
    servo = np.array([1.0, gain * float(data["kp"]), gain, 0.0, 0.0, 1.0])  # u = kv (kp (q - q_m) - q_m')
    position, force = moved(found, record, np.zeros(record.size), servo, data["qg"])
    assert np.abs(force / data["gtau"]).max() < 10.0, "where the command would be limited [V]"
    errors = {"position": share(record, position)}
    errors["raw"] = share(np.gradient(record, 1e-3), np.gradient(position, 1e-3))
    errors["recipe"] = share(recipe_velocity(record), recipe_velocity(position))
    smoother = share(recipe_velocity(record, 20.0), recipe_velocity(position, 20.0))
    message = ", ".join(f"{name} {error:.4f} %" for name, error in errors.items())
    measured(f"{message}, up to 20 Hz {smoother:.4f} %")
    assert errors["position"] <= 0.02, f"{errors} %"
    assert max(errors["raw"], errors["recipe"]) <= 0.25, f"{errors} %"


def moved(found, record, force, servo=None, reference=0.0):
    """Position and force of the identified axis from the record's first position and speed."""
    values = dict(
        zip(
            ("inertia", "viscous", "coulomb", "offset"), map(found.__getitem__, found.parameters), strict=True
        )
    )
    axis = parameters(**values, start=record[0], start_speed=(record[1] - record[0]) / 1e-3)
    wanted, nothing = np.zeros((3, record.size)), np.zeros(record.size)
    wanted[0], position, acting = reference, np.empty(record.size), np.empty(record.size)
    servo = np.zeros(6) if servo is None else servo
    move(axis, force, nothing, wanted, servo, np.zeros(4), 1e-3, 4, 0, position, acting)
    return position, acting


def share(measured, simulated):
    """Norm of the difference over that of the measured [%]."""
    return 100 * np.linalg.norm(measured - simulated) / np.linalg.norm(measured)


def recipe_velocity(position, limit=100.0):
    smooth = signal.filtfilt(*signal.butter(4, limit / 500.0), position, padlen=12)
    return np.gradient(smooth, 1e-3)


def test_parameters_of_one_half_explain_the_force_of_the_other(log, measured):
    """By the authors' recipe, as its own residual of 4.1 % does: at most 6 %, forth and back."""
    position, force = log.channel("position"), log.channel("force")
    halves = [slice(0, position.size // 2), slice(position.size // 2, None)]
    shares = []
    for own, other in (halves, halves[::-1]):
        rows, seen = recipe_rows(position[other], force[other])
        off = seen - rows @ published(position[own], force[own])[0]
        shares.append(np.linalg.norm(off) / np.linalg.norm(seen))
    measured(f"{100 * shares[0]:.2f} and {100 * shares[1]:.2f} %")
    assert max(shares) < 0.06, shares


def test_the_open_loop_needs_a_small_disturbance_to_follow(log, measured):
    """Half a second under the measured force alone drifts by a tenth of the stroke.

    A constant 2.1 N more, a tenth of the Coulomb friction, bring it to a quarter of a per cent.
    """
    found = axis_of([log], AxisOptions()).regressed()
    record, force = log.channel("position")[:500], log.channel("force")[:500]

    def off(disturbance):
        return float(np.abs(moved(found, record, force + disturbance)[0] - record).max() / np.ptp(record))

    best = min(np.linspace(-4.0, 4.0, 81), key=off)
    measured(f"alone {100 * off(0.0):.1f} % of the stroke, with {best:.1f} N {100 * off(best):.2f} %")
    assert off(0.0) < 0.15, off(0.0)
    assert off(best) < 0.01, off(best)
    assert abs(best) < 0.15 * found["coulomb_friction"], best


# --- Coupled electric drives, PRBS records: a belt, friction and a rectifying sensor against every linear
def rms_of(measured, simulated):
    """Root mean square of the difference."""
    return float(np.sqrt(np.mean((measured - simulated) ** 2)))


FILE_COUPLED = "ced/DATAPRBS.MAT"
TRAINING = 400


def modelled(*parts, **given):
    """Two inertias from rows of name, quantity, number, low, high and start; and where the fit starts."""
    names = ("name", "quantity", "number", "low", "high")
    free = tuple(FreeParameter(**dict(zip(names, row, strict=False))) for row in parts)
    return ChainModel(inertias=2, free=free, **given), {row[0]: row[-1] for row in parts}


BELT, START = modelled(
    ("motor inertia", "inertia", 0, 1e-4, 1.0, 0.03),
    ("pulley inertia", "inertia", 1, 1e-4, 1.0, 0.01),
    ("motor friction", "viscous", 0, 1e-5, 10.0, 0.15),
    ("pulley friction", "viscous", 1, 1e-5, 10.0, 0.02),
    ("coulomb friction", "coulomb", 0, 1e-5, 1.0, 0.3),
    ("belt stiffness", "stiffness", 0, 1e-2, 1e2, 2.0),
    ("belt damping", "damping", 0, 1e-5, 10.0, 0.01),
    ("sensor lag", "lag", 0, 1e-4, 0.2, 0.02),
    ("sensor threshold", "threshold", 0, 1e-4, 1.0, 0.1),
    measured=(1,),
    rectified=True,
    delay=1,
    substeps=5,
)
"""Torque in volt, speed in ticks: the scale is in the inertias. The computer writes one sample late."""


@pytest.fixture(scope="module")
def all_records(shared_data):
    data = io.loadmat(shared_data(FILE_COUPLED), squeeze_me=True)
    return [
        Record(input=data[f"u{k}"].astype(float), output=data[f"z{k}"][:, None], interval=0.02)
        for k in (1, 2, 3)
    ]


@pytest.fixture(scope="module")
def records(all_records):
    return all_records[:2]


@pytest.fixture(scope="module")
def belt(records):
    return fit_output_error([record.begun(TRAINING) for record in records], BELT, START)


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
    doubts = [one.code for one in belt.doubts([record.begun(TRAINING) for record in all_records[:2]])]
    assert "residual-not-white" in doubts, doubts


def linear_errors(records, belt, order, signed):
    """RMSE on the last samples of one linear model for both records, the best of four random starts."""
    # the angle of the pulley rises with the sign of its speed
    plain = replace(BELT, free=BELT.free[:7], rectified=False)
    values = {s.name: belt.values[s.name] for s in plain.free}
    turned = [np.cumsum(plain.moved(values, record, sensitive=False)[0][:, 0]) for record in records]
    signs = [np.sign(np.diff(angle, prepend=0.0)) if signed else 1.0 for angle in turned]
    targets = [r.output[:, 0] * s for r, s in zip(records, signs, strict=True)]
    inputs = [np.concatenate([[0.0], r.input[:-1]]) for r in records]
    best = None
    for start in np.random.default_rng(0).normal(size=(4, 2 * order + 2)):
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


def run(parameters, u, order):
    """Poles inside the unit circle whatever the coefficients: reflection coefficients by tanh."""
    denominator = np.array([1.0])
    for k in np.tanh(parameters[:order]):
        longer = np.append(denominator, 0.0)
        denominator = longer + k * longer[::-1]
    return signal.lfilter(parameters[order : 2 * order + 1], denominator, u) + parameters[-1]


# --- A motor cart, a spring and a load cart: one physical model from four runs, tested on all others
TRAINING_CART = ("1_5", "2", "sine_1", "sine_3")
MOVING = ("0_5", "1_5", "2", "2_5", "3_5", "4", "4_5")
"""Sines [Hz] that were not fitted and at which the load cart moves; above 4.5 Hz it sticks."""
SWEEP = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5)
SETTLED = 2000
CARTS, START_CART = modelled(
    ("motor cart", "inertia", 0, 1e-5, 1.0, 2e-3),
    ("load cart", "inertia", 1, 1e-5, 1.0, 1e-3),
    ("motor viscous", "viscous", 0, 1e-6, 1.0, 0.01),
    ("load viscous", "viscous", 1, 1e-7, 1.0, 1e-3),
    ("motor coulomb", "coulomb", 0, 1e-4, 3.0, 0.3),
    ("load coulomb", "coulomb", 1, 1e-4, 3.0, 0.05),
    ("spring", "stiffness", 0, 1e-3, 1e2, 0.3),
    ("offset", "offset", 0, -1.0, 1.0, 0.0),
    measured=(0, 1),
    substeps=1,
)
"""Masses [V/(mm/s^2)], viscous terms [V s/mm], Coulomb terms and offset [V], spring [V/mm]."""


@pytest.fixture(scope="module")
def run_cart(shared_data):
    def read(name):
        data = io.loadmat(shared_data(f"flexible_cart/velocity_response_{name}.mat"), squeeze_me=True)
        output = np.column_stack([data["v1"], data["v2"]]).astype(float)
        return Record(input=data["u"].astype(float), output=output, interval=1e-3)

    return read


@pytest.fixture(scope="module")
def carts(run_cart):
    return fit_output_error([run_cart(name) for name in TRAINING_CART], CARTS, START_CART)


def test_the_motor_cart_is_predicted_in_every_run_that_was_not_fitted(run_cart, carts, measured):
    """Fit of at least 85 % of the raw encoder differences, of which rounding alone leaves 1 to 2 %."""
    fits = {}
    for name in MOVING:
        record = run_cart(f"sine_{name}")
        speed = record.output[:, 0]
        off = np.linalg.norm(speed - carts.simulated(record)[:, 0])
        fits[name] = 100.0 * (1.0 - off / np.linalg.norm(speed - speed.mean()))
    measured(", ".join(f"{name.replace('_', '.')} Hz {fit:.1f} %" for name, fit in fits.items()))
    assert min(fits.values()) >= 85.0, f"{fits}"


def test_the_resonance_is_within_three_per_cent_of_the_measured_response(run_cart, carts, measured):
    """Highest gain above 2 Hz of a spline through the gains at the sines, measured and simulated alike.

    The sines lie 0.5 Hz apart, so the figure depends on how one interpolates; the spline was chosen after
    others. A parabola through the three highest logarithms of the gain stands beside it, with its own bound.
    """
    gains = []
    for frequency in SWEEP:
        record = run_cart("sine_" + f"{frequency:g}".replace(".", "_"))
        simulated = carts.simulated(record)
        gains.append([gain(record.input, x[:, 0], frequency) for x in (record.output, simulated)])
    fine = np.linspace(2.0, 4.5, 5001)
    splines = [CubicSpline(np.log(SWEEP), np.log(g)) for g in np.transpose(gains)]
    observed, modelled = (fine[np.argmax(spline(np.log(fine)))] for spline in splines)
    off = modelled / observed - 1
    other = [parabola(np.array(g)) for g in np.transpose(gains)]
    beside = other[1] / other[0] - 1
    measured(f"{100 * off:+.1f} %: {modelled:.3f} against {observed:.3f} Hz; parabola {100 * beside:+.1f} %")
    assert abs(beside) <= 0.1, f"{other}"
    assert abs(off) <= 0.03, f"measured {observed:.3f} Hz, model {modelled:.3f} Hz"


def gain(input_, output, frequency):
    """Of the fundamental, after two seconds."""
    time = 1e-3 * np.arange(input_.size)[SETTLED:]
    wave = np.exp(-2j * np.pi * frequency * time)
    return abs(np.mean(output[SETTLED:] * wave)) / abs(np.mean(input_[SETTLED:] * wave))


def parabola(gains):
    """Vertex through the highest gain above 2 Hz and its neighbours, in the logarithm."""
    frequency, level = np.array(SWEEP), np.log(gains)
    k = 2 + int(np.argmax(level[3:-1])) + 1
    rise = np.polyfit(frequency[k - 1 : k + 2], level[k - 1 : k + 2], 2)
    return -rise[1] / (2 * rise[0])
