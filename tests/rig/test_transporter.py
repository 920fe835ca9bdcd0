"""The transporter: its model against certified modes, its plant against the model, its laws compared."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.control import transporter
from cabledrive.control.load_schedule import scheduled_step
from cabledrive.modal import natural_frequencies
from cabledrive.parameters import load_drive
from cabledrive.reduction.transporter import (
    compliance,
    frozen_frequencies,
    frozen_state_space,
    strand_stiffness,
    transporter_of,
)
from cabledrive.rig.carriage import (
    CarriageLoop,
    CarriageMove,
    move_carriage,
    one_count,
    run_transporter,
    transporter_advance,
    transporter_rates,
)
from cabledrive.trajectories import Move, Trajectory
from rig_runs import along_the_way, residual_motion, scaled_transporter

DRIVE = scaled_transporter(load_drive("dissertation-transporter").listed)
MACHINE = transporter_of(DRIVE, payload_mass=0.25, line_length=0.25)
FREE = MACHINE._replace(
    viscous=0.0, coulomb=0.0, offset=0.0, rail_friction=0.0, swing_damping=0.0, damping_time=0.0
)
INTERVAL = 1.0 / 5000.0
LAWS = ("scheduled", "pd-flat", "pd", "shaper")


@pytest.mark.parametrize("position", [0.25, 0.75, 1.25])
def test_frequency_at_each_place_is_the_certified_one(position, measured):
    """Carriage on the cable beside the distributed cable with its mass: within 0.3 %."""
    there = replace(DRIVE, carriage=(replace(DRIVE.carriage[0], position=position),))
    certified = natural_frequencies(there, count=1)[0]
    found = frozen_frequencies(MACHINE._replace(payload_mass=1e-9), position)[1] / (2.0 * np.pi)
    measured(f"{100 * (found / certified - 1.0):+.3f} % of {certified:.2f} Hz")
    assert found == pytest.approx(certified, rel=3e-3), f"observed {found:.4f} Hz, certified {certified:.4f}"


def test_compliance_is_that_of_the_strands_and_so_are_its_derivatives():
    for x in (0.2, 0.7, 1.3):
        first, second, third = strand_stiffness(MACHINE, x)
        c, slope, bend = (float(v) for v in compliance(MACHINE, np.array(x)))
        assert c == pytest.approx(1.0 / (first + second * third / (second + third)), rel=1e-12)
        step = 1e-4
        after, before = (float(compliance(MACHINE, np.array(x + s))[0]) for s in (step, -step))
        assert slope == pytest.approx((after - before) / (2 * step), rel=1e-6, abs=1e-12)
        assert bend == pytest.approx((after - 2 * c + before) / step**2, rel=1e-4)


def rates(machine, x, force=0.0):
    out = np.zeros(8)
    transporter_rates(machine, x, (force, 0.0), False, np.zeros(3), out)
    return out


@pytest.mark.kernel
def test_small_motions_of_the_plant_are_those_of_the_frozen_model():
    """Differences of the nonlinear rates at rest against the state space; prestrain aside."""
    machine = FREE._replace(damping_time=5e-4, pretension=1e-6)
    a = frozen_state_space(machine, machine.start)[0]
    swing = np.eye(8)  # angle per payload displacement
    swing[3, 3] = swing[7, 7] = 1.0 / machine.line_length
    swing[3, 1] = swing[7, 5] = -1.0 / machine.line_length
    found = np.zeros((8, 8))
    taut = machine._replace(pretension=1.0)  # so that no strand goes slack
    for j in range(8):
        step = np.zeros(8)
        step[j] = 1e-7
        found[:, j] = (rates(taut, step) - rates(taut, -step)) / 2e-7
    expected = swing @ a @ np.linalg.inv(swing)
    np.testing.assert_allclose(found, expected, rtol=4e-3, atol=1e-6 * np.abs(expected).max())


@pytest.mark.kernel
def test_energy_is_kept_where_nothing_loses_it(measured):
    """Swing, carriage and pulleys under strands that change their length: 1e-7 of it over 0.1 s."""
    work, tensions = np.zeros((5, 8)), np.zeros(3)
    x = np.array([0.0, 2e-3, 0.0, 0.3, 0.1, 0.1, 0.1, -0.2])
    prestrain = FREE.pretension / FREE.axial_rigidity

    def energy():
        natural = (
            FREE.start + x[0] / (1 + prestrain),
            FREE.span_length - FREE.start - x[2] / (1 + prestrain),
            FREE.span_length + (x[2] - x[0]) / (1 + prestrain),
        )
        transporter_rates(FREE, x, (0.0, 0.0), False, tensions, work[0])
        strains = tensions / FREE.axial_rigidity
        cable = 0.5 * FREE.axial_rigidity * sum(n * e**2 for n, e in zip(natural, strains, strict=True))
        speed = np.array(
            [x[5] + FREE.line_length * np.cos(x[3]) * x[7], FREE.line_length * np.sin(x[3]) * x[7]]
        )
        kinetic = 0.5 * (FREE.masses[:3] @ x[4:7] ** 2 + FREE.payload_mass * speed @ speed)
        height = FREE.line_length * (1 - np.cos(x[3]))
        return kinetic + cable + FREE.payload_mass * FREE.gravity * height

    before, handled = energy(), 0.5 * FREE.masses[:3].sum() * 0.1**2
    for _ in range(1000):
        transporter_advance(FREE, x, (0.0, 0.0), 1e-4, tensions, work)
    off = (energy() - before) / handled
    measured(f"{off:.1e} of the energy handled")
    assert abs(off) < 1e-7, f"observed {off:.2e}"


def test_flat_motion_carries_the_payload_there():
    """A small move of the whole plant without Coulomb friction, ideal sensors: 4 um of 20 mm."""
    smooth = replace(DRIVE, motor=replace(DRIVE.motor, coulomb_friction=0.0))
    move = CarriageMove(distance=0.02, duration=1.5, rest=0.5)
    run = move_carriage(smooth, "pd-flat", move=move, ideal_sensors=True)
    worst = np.abs(run.payload - run.wanted).max()
    assert worst < 4e-6, f"observed {worst:.2e} m"


@pytest.mark.parametrize(
    ("places", "rigidities"),
    [(12, (0.9, 1.0, 1.1)), pytest.param(41, (0.9, 0.95, 1.0, 1.05, 1.1), marks=pytest.mark.verify)],
)
def test_every_place_is_stable_and_one_design_for_all_is_not(places, rigidities, measured):
    """Poles of law, observer and plant along the way, EA 10 % off as well."""
    for rigidity in rigidities:
        growth = along_the_way(DRIVE, "scheduled", positions=places, rigidity=rigidity)[0].max()
        measured(f"EA x {rigidity:g}: largest real part {growth:.3f} 1/s")
        assert growth < 0.0, f"EA x {rigidity}: observed {growth:.3f} 1/s"
    frozen, _ = along_the_way(DRIVE, "frozen", positions=5)
    assert frozen[-1] > 1.0, f"observed {frozen[-1]:.2f} 1/s"
    assert frozen[2] < 0.0


def sizes_of(residuals, when):
    """Median and worst of each law, in words."""
    sizes = {law: 1e3 * found[when] for law, found in residuals.items()}
    return ", ".join(f"{law} {np.median(own):.2f} / {own.max():.2f}" for law, own in sizes.items()) + " mm"


@pytest.mark.parametrize("runs", [2, pytest.param(16, marks=pytest.mark.verify)])
def test_residual_motion_is_less_than_a_fifth_of_that_under_pd(runs, measured):
    """0.5 kg over 1 m in 2.5 s: about 1 mm, as with the shaper; 83 mm of PD with rigid feedforward."""
    found = {law: residual_motion(DRIVE, law, runs=runs) for law in LAWS}
    measured(sizes_of(found, 0))
    worst = {law: one[0].max() for law, one in found.items()}
    assert max(worst["scheduled"], worst["shaper"]) < 0.2 * worst["pd"], f"observed {worst}"
    assert worst["scheduled"] < 2.5e-3


@pytest.mark.verify
def test_still_air_over_forty_draws(measured):
    """Worst of the scheduled law a fifth of every worst under PD with rigid feedforward, shaped or not."""
    found = {law: residual_motion(DRIVE, law, runs=40, seed=1, among=True) for law in LAWS}
    worst = {law: one[0].max() for law, one in found.items()}
    measured(sizes_of(found, 0))
    assert worst["scheduled"] < 0.05 * worst["pd"], f"observed {worst}"
    assert worst["scheduled"] < 0.5 * worst["shaper"], f"observed {worst}"
    assert worst["scheduled"] < worst["pd-flat"], f"observed {worst}"


@pytest.mark.verify
def test_after_a_gust_over_forty_draws(measured):
    found = {law: residual_motion(DRIVE, law, runs=40, seed=1, among=True, gust=0.2) for law in LAWS}
    later = {law: np.median(one[1]) for law, one in found.items()}
    measured(f"at once {sizes_of(found, 0)}; two seconds later {sizes_of(found, 1)}")
    assert later["scheduled"] < 0.1 * min(later["pd"], later["pd-flat"], later["shaper"]), f"observed {later}"


def test_shaper_starts_with_the_motion_and_ends_with_it_later():
    time = np.asarray(INTERVAL * np.arange(20000), dtype=np.float64)
    way = Trajectory(moves=(Move(start=0.0, duration=2.0, distance=1.0),), duration=4.0, order=13)
    given, late = transporter.shaped(MACHINE, way(time, 2), INTERVAL, 0.75)
    assert given[0, 0] == 0.0
    assert given[0, -1] == pytest.approx(1.0, rel=1e-12)
    assert late == pytest.approx(0.5 / 0.995 + 0.5 / 9.1, rel=0.03)


def test_one_bandwidth_gives_the_weights_that_were_chosen_by_hand():
    """The weights of the section on the transporter are those of 6.7 Hz, within 15 %."""
    found = transporter.tuning_for(MACHINE, 2.0 * np.pi * 6.7, interval=INTERVAL, count=one_count(DRIVE))
    chosen = transporter.TransporterTuning()
    for name in ("force", "stretching"):
        ratio = getattr(found, name) / getattr(chosen, name)
        assert ratio == pytest.approx(1.0, abs=0.15), f"{name}: observed {ratio:.3f}"


@pytest.mark.kernel
def test_a_run_is_its_samples_one_after_another():
    """Readings in whole counts, force of the law, log, internal steps; it ends where a strand goes slack."""
    law = transporter.scheduled_law(
        MACHINE, interval=INTERVAL, count=one_count(DRIVE), limit=70.0, positions=np.linspace(0.2, 1.3, 3)
    )
    count, phases, samples, substeps = one_count(DRIVE), np.array([0.2, -0.3]), 6, 2
    reference = 1e-3 * np.random.default_rng(4).normal(size=(samples, transporter.STATES + 2))
    wind, log = np.linspace(0.0, 5.0, samples), np.zeros((samples, 13))
    loop = CarriageLoop(law, reference, wind, INTERVAL, substeps, count)
    assert run_transporter(loop, MACHINE, phases, np.zeros(8), log) == samples
    x, estimate, fresh = np.zeros(8), np.zeros(transporter.OBSERVED), np.zeros(transporter.OBSERVED)
    tensions, work = np.zeros(3), np.zeros((5, 8))
    for k in range(samples):
        readings = count * np.rint(x[[0, 2]] / count + phases)
        force = scheduled_step(law, estimate, readings, reference, k, fresh)
        place = x[1] + MACHINE.line_length * np.sin(x[3])
        np.testing.assert_array_equal(log[k, :9], [*x, place])
        assert log[k, 12] == force
        np.testing.assert_allclose(log[k, 9:12], MACHINE.pretension, rtol=0.2)
        for _ in range(substeps):
            transporter_advance(MACHINE, x, (force, wind[k]), INTERVAL / substeps, tensions, work)
    slack, gone = np.zeros(8), np.zeros(8)
    slack[0], gone[1] = 1.0, MACHINE.span_length
    for start in (slack, gone):
        assert run_transporter(loop, MACHINE, phases, start, log) == 0
