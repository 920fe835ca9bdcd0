"""Modes with the rotor free, held or on its holding stiffness, against elements that know no chain."""

from dataclasses import replace

import numpy as np
import pytest
from machines import machine, spread
from parts import below
from spectral_elements import frequencies

import cabledrive as cd
from cabledrive.mechanics.spans import longitudinal_chains
from oracles.chain_count import modes_below

AGREEMENT, MODES = 1e-8, 10
CONDITIONS = ("free", "held", "holding")
QUICK = pytest.mark.parametrize(
    "seed",
    [pytest.param(n, marks=() if n % 10 == 0 else pytest.mark.verify, id=f"machine-{n}") for n in range(100)],
)


def drawn(rng):
    """A machine that has a motor and, half of the time, a holding stiffness; and what is held of it."""
    while True:
        drive = machine(rng, contrast=100.0)
        if not drive.drive_pulley.fixed:
            break
    if drive.motor is not None and rng.random() < 0.7:
        stiffness = drive.cable.axial_rigidity / drive.span_length * spread(rng, 1e4)
        holding = stiffness * drive.drive_pulley.radius**2
        drive = replace(drive, motor=replace(drive.motor, holding_stiffness=holding))
    sprung = drive.motor is not None and drive.motor.holding_stiffness is not None
    motor = rng.choice(CONDITIONS[: 3 if sprung else 2])
    parts = ["drive pulley", "load pulley", *(f"carriage {n}" for n in range(len(drive.carriage)))]
    hold = [part for part in parts if rng.random() < 0.6 / len(parts)]
    return drive, str(motor), hold


def elements(drive, motor, hold):
    """Frequencies by spectral elements on joints laid out anew from the drive [rad/s], and their blur."""
    first, second, square = drive.drive_pulley, drive.load_pulley, drive.drive_pulley.radius**2
    rotor = drive.motor
    joint = rotor.joint_stiffness if rotor else None
    rigid = rotor.inertia if rotor and joint is None else 0.0
    joints = [("drive pulley", (first.inertia + rigid) / square)]
    lengths = []
    for span in drive.spans:
        place = 0.0
        for carriage in drive.carriages_on(span):
            joints.append((f"carriage {drive.carriage.index(carriage)}", carriage.mass))
            lengths.append(carriage.position - place)
            place = carriage.position
        lengths.append(drive.span_length - place)
        if span == "upper":
            joints.append(("load pulley", second.inertia / second.radius**2))
    names, masses = zip(*joints, strict=True)
    held = {names.index(name) for name in hold}
    held |= {
        names.index(n) for n, p in zip(("drive pulley", "load pulley"), drive.pulley, strict=True) if p.fixed
    }
    grounds, pendant, rotor_ground = np.zeros(len(names)), None, 0.0
    if motor == "held" and joint is None:
        held.add(0)
    elif motor == "held":
        grounds[0] = joint / square
    elif joint is not None:
        pendant = joint / square, rotor.inertia / square, 0
        rotor_ground = rotor.holding_stiffness / square if motor == "holding" else 0.0
    elif motor == "holding":
        grounds[0] = rotor.holding_stiffness / square
    rigidity, density = drive.cable.axial_rigidity, drive.cable.mass_per_length
    return frequencies(
        lengths, masses, rigidity, density, closed=drive.kind == "loop", fixed=held, pendant=pendant,
        grounds=grounds, rotor_ground=rotor_ground,
    )  # fmt: skip


@QUICK
def test_modes_agree_with_elements_however_the_machine_is_held(seed, measured):
    drive, motor, hold = drawn(np.random.default_rng(seed))
    found = cd.modes(drive, count=MODES, motor=motor, hold=hold)
    listed = 2 * np.pi * np.repeat(
        [mode.frequency for mode in found.longitudinal], [mode.multiplicity for mode in found.longitudinal]
    )  # fmt: skip
    omegas, blurs = (values[:MODES] for values in elements(drive, motor, hold))
    clear = blurs < AGREEMENT
    error = np.abs(listed[:MODES] / omegas - 1.0)[clear]
    measured(f"relative error {error.max(initial=0.0):.1e} in {clear.sum()} modes clear of round-off")
    assert found.certified
    assert clear.sum() >= MODES / 2, f"only {clear.sum()} modes are clear of round-off"
    assert error.max() <= AGREEMENT, f"{motor}, hold {hold}: error {error.max():.2e}"


def test_counts_with_grounds_and_held_joints_agree_with_the_matrix(measured):
    """On the chains of 200 machines that are held in all ways."""
    rng = np.random.default_rng(3)
    wrong, counts = [], 0
    for number in range(200):
        drive, motor, hold = drawn(rng)
        for labelled in longitudinal_chains(drive, motor=motor, hold=hold):
            chain = labelled.chain
            for omega in 40.0 * rng.random(8) / chain.travel_times.sum():
                counts += 1
                if below(chain, omega) != modes_below(chain, omega):
                    wrong.append(f"machine {number}, {motor}, hold {hold}, omega {omega:.17g}")
    measured(f"{len(wrong)} disagreements in {counts:,} counts")
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize(
    ("name", "motor", "hold", "hertz", "digits"),
    [
        ("linear-axis", "free", [], 99.28, 0.005),
        ("linear-axis", "held", [], 34.00, 0.005),
        ("linear-axis", "free", ["drive pulley"], 35.3, 0.05),
        ("elevator", "free", [], 3.51, 0.005),
        ("elevator", "held", [], 2.42, 0.005),
        ("printer-belt", "free", [], 181.46, 0.005),
        ("printer-belt", "held", [], 96.12, 0.005),
    ],
)
def test_lowest_frequency_depends_on_how_the_motor_is_held(name, motor, hold, hertz, digits):
    found = cd.natural_frequencies(cd.load_drive(name), count=1, motor=motor, hold=hold)[0]
    assert found == pytest.approx(hertz, abs=digits), f"{found}"


def test_holding_stiffness_is_a_joint_to_a_rotor_of_infinite_inertia():
    """The rotor's inertia on the pulley, the spring as the joint to a flywheel of 1e6 kg m^2."""
    sprung = cd.load_drive("printer-belt")
    trick = cd.load_drive(
        "printer-belt",
        overrides=["pulley.0.inertia=5.56e-6", "motor.inertia=1e6", "motor.joint_stiffness=20"],
    )
    trick = replace(trick, motor=replace(trick.motor, holding_stiffness=None))
    found = cd.natural_frequencies(sprung, count=3)
    assert found == pytest.approx([84.6786, 338.9427, 746.898], abs=6e-4), f"{found}"
    assert found == pytest.approx(cd.natural_frequencies(trick, count=3), rel=1e-9)
    assert cd.modes(sprung, count=1).rigid_body_modes == 0


@pytest.mark.parametrize("joint", [[], ["motor.joint_stiffness=50 N m/rad"]])
def test_holding_stiffness_runs_from_the_free_motor_to_the_held_one(joint):
    def lowest(stiffness, **options):
        settings = [*joint, f"motor.holding_stiffness={stiffness!r}"]
        return cd.natural_frequencies(cd.load_drive("printer-belt", overrides=settings), count=2, **options)

    free, held = (lowest(1.0, motor=motor) for motor in ("free", "held"))
    assert lowest(1e-9)[1] == pytest.approx(free[0], rel=1e-9)
    assert lowest(1e9)[0] == pytest.approx(held[0], rel=1e-6)
    rising = [lowest(k)[0] for k in (1e-3, 1.0, 20.0, 1e3)]
    assert np.all(np.diff(rising) > 0.0), f"{rising}"


def test_motor_of_a_held_drive_pulley_vibrates_on_its_joint_alone():
    drive = cd.load_drive("linear-axis")
    alone = np.sqrt(drive.motor.joint_stiffness / drive.motor.inertia) / (2 * np.pi)
    found = cd.natural_frequencies(drive, below=1000.0, hold=["drive pulley"])
    assert np.min(np.abs(found / alone - 1.0)) < 1e-12, f"{alone} Hz among {found}"


def test_default_is_holding_where_the_file_has_the_stiffness():
    bare = cd.load_drive("linear-axis")
    sprung = cd.load_drive("linear-axis", overrides=["motor.holding_stiffness=100"])
    assert (cd.modes(bare, count=1).motor, cd.modes(sprung, count=1).motor) == ("free", "holding")
    free = cd.natural_frequencies(sprung, count=3, motor="free")
    assert free == pytest.approx(cd.natural_frequencies(bare, count=3), rel=1e-15)


def test_held_carriage_parts_the_transverse_motion_too():
    drive = cd.load_drive("elevator")
    hanging = replace(drive, carriage=tuple(replace(c, guided=False) for c in drive.carriage))
    guided = replace(drive, carriage=tuple(replace(c, guided=True) for c in drive.carriage))
    found = [m.frequency for m in cd.modes(hanging, count=6, hold=["carriage 0", "carriage 1"]).transverse]
    assert found == pytest.approx([m.frequency for m in cd.modes(guided, count=6).transverse], rel=1e-12)


def test_carriage_is_held_by_its_own_name_which_is_no_part_of_the_hash():
    plain = cd.load_drive("elevator")
    named = cd.load_drive("elevator", overrides=["carriage.0.name=car"])
    assert cd.content_hash(named) == cd.content_hash(plain)
    assert cd.natural_frequencies(named, hold=["car"]) == pytest.approx(
        cd.natural_frequencies(plain, hold=["carriage 0"]), rel=1e-15
    )


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"motor": "stuck"}, "free, held or holding"),
        ({"motor": "holding"}, "motor.holding_stiffness"),
        ({"hold": ["carriage 1"]}, 'did you mean "carriage 0"'),
        ({"hold": ["motor"]}, 'motor = "held"'),
    ],
)
def test_what_cannot_be_held_is_refused_in_one_line(options, words):
    with pytest.raises(cd.InputRefused, match=words) as refused:
        cd.modes(cd.load_drive("linear-axis"), count=1, **options)
    assert "\n" not in str(refused.value)
