"""What the rig refuses: each row a call, the quantity that is named and the numbers or choices it met."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numba
import numpy as np
import pytest

import cabledrive as cd
from cabledrive.app.tracked import parse_payload_range
from cabledrive.reduction.transporter import transporter_of
from cabledrive.reduction.two_motors import winched_machine
from cabledrive.rig import BodyMotion, Disturbance, Motion, Payload, RigOptions, track
from cabledrive.rig.carriage import CarriageMove, move_carriage
from cabledrive.rig.laws.controller_file import controller_numbers
from cabledrive.rig.laws.controllers import DesignSpec
from cabledrive.rig.laws.load_learning import LOAD_LEARNING as LEARNING
from cabledrive.rig.laws.load_learning import SCHEDULED
from cabledrive.rig.plant_samples import Disturbances, disturbances_of, disturbed_loop
from cabledrive.rig.setting import parse_disturbance, parse_encoder_dropout
from cabledrive.rig.tuning import design
from command import refused
from other_units import in_other_units
from rig_runs import loop_of, scaled_transporter

DRIVE = cd.load_drive("dissertation-3").listed
LOOSE = cd.load_drive("dissertation-3", overrides=["motor.backlash=1 deg"]).listed
SMOOTH = tuple(f"{part}.coulomb_friction=0" for part in ("motor", "pulley.0", "pulley.1"))
LINEAR = cd.load_drive("dissertation-3", overrides=[*SMOOTH, "motor.backlash=0"]).listed
CAMERA = cd.load_drive("camera-winches")
LINE = scaled_transporter(cd.load_drive("dissertation-transporter").listed)
SHORT = Motion(angle=5.0, rise=0.15, dwell=0.05, order=11)
IDEAL = RigOptions(ideal_sensors=True)
WIDE = Motion(order=11, payload=(Payload(factor=3.5, start=0.7),), payload_range=(0.5, 4.0))


def tracked(*named, drive=DRIVE, **choices):
    """A row: a run of the rig, and what its refusal names."""
    return pytest.param(lambda: track(drive, **choices), named, id=f"{choices}"[:60])


def row(call, *named):
    return pytest.param(call, named, id=" ".join(named))


def with_motor(**values):
    return replace(DRIVE, motor=replace(DRIVE.motor, **values))


def unmade_law(**changes):
    return lambda: design("darc-4", replace(DesignSpec(DRIVE, Motion()), **changes))


def late_plant():
    loop = loop_of("lqi", DRIVE, SHORT, bandwidth=20.0)
    disturbed_loop(loop, Disturbances(added_delay=(1e-3, 1e-3)), np.random.default_rng(0))


RUNS = [
    tracked("sample", controller="darc-4", bandwidth=400.0),
    tracked("gains", "best or dissertation", gains="fast"),
    tracked("adapt", "pid", controller="pid", adapt=False),
    tracked("segments", "cable", options=RigOptions(segments=9)),
    tracked("motor.joint_stiffness", drive=with_motor(joint_stiffness=None), controller="darc-4"),
    tracked("ideal sensors", controller="darc-indirect", motion=replace(SHORT, pulses=2), options=IDEAL),
    tracked("backlash", controller="pd", plant="cable", drive=with_motor(backlash=0.01)),
    tracked("innovations", controller=LEARNING, bandwidth=20.0, options=IDEAL),
    tracked("innovations", controller=LEARNING, bandwidth=20.0, options=RigOptions(observer="difference")),
    tracked("repeat", controller="darc-4-damped", bandwidth=23.0, motion=SHORT, repeat=3),
    tracked("repeat", controller="darc-indirect", bandwidth=23.0, motion=SHORT, repeat=3),
    tracked("repeat", controller="lqg", bandwidth=23.0, motion=SHORT, repeat=3, draws=2),
    tracked("from 2 to", controller="lqg", bandwidth=23.0, motion=SHORT, repeat=1),
    tracked("lqi", SCHEDULED, controller="lqi", bandwidth=20.0, motion=WIDE),
    tracked("load_change", bandwidth=20.0, plant="cable", options=RigOptions(load_change=(0.7, 3.0))),
    tracked("load_change", "9 s", "2 s", bandwidth=20.0, options=RigOptions(load_change=(9.0, 2.0))),
    tracked(
        *("payload", "9 s", "2 s"), controller=SCHEDULED, bandwidth=20.0,
        motion=Motion(payload=(Payload(factor=2.0, start=9.0),)),
    ),
    row(lambda: RigOptions(preload=0.5), "preload", "--pair"),
    tracked("friction", drive=LOOSE, controller="lqg", options=RigOptions(pair=True, preload=0.05)),
    tracked("torque limit", drive=LOOSE, controller="lqg", options=RigOptions(pair=True, preload=2.5)),
    tracked("lumped chain", drive=LOOSE, controller="lqg", plant="model-3", options=RigOptions(pair=True)),
    *(tracked("two winches", **{key: value}) for key, value in
      {"gust": 3.0, "least_tension": 3.0, "motion": BodyMotion()}.items()),
]  # fmt: skip
WINCHES = [
    row(lambda: track(CAMERA, motion=BodyMotion(moves={"camera.z": 1.0})), "coordinate", "camera.z"),
    row(lambda: track(CAMERA, bandwidth=9.0), "bandwidth", "9"),
    row(lambda: track(CAMERA, motion=BodyMotion(moves={"camera.y": 4.9})), "move"),
    row(
        lambda: track(
            CAMERA,
            options=RigOptions(
                disturbances=(Disturbance(on="camera.x", torque=1.0, start=900.0, end=901.0),)
            ),
        ),
        *("start earlier", "900"),
    ),
    tracked("BodyMotion", drive=CAMERA, motion=Motion()),
    tracked("gains", drive=CAMERA, gains="dissertation"),
    tracked("jitter", drive=CAMERA, options=RigOptions(jitter=1e-5)),
    row(lambda: cd.compare(CAMERA, draws=1), "cabledrive track"),
    row(
        lambda: winched_machine(
            replace(CAMERA, motor=(replace(CAMERA.motor[0], backlash=0.01), CAMERA.motor[1]))
        ),
        "backlash",
    ),
]
CARRIAGES = [
    row(lambda: move_carriage(LINE, law="darc"), "darc"),
    row(lambda: move_carriage(LINE, move=CarriageMove(distance=1.3)), "shorten the way"),
    row(lambda: move_carriage(LINE, law="shaper", move=CarriageMove(duration=0.5)), "take longer"),
    row(lambda: CarriageMove(payload_mass=0.0), "payload_mass"),
    row(lambda: CarriageMove(duration=-1.0), "duration"),
    row(lambda: CarriageMove(line_length=float("nan")), "line_length"),
    row(lambda: CarriageMove(distance=0.0), "distance"),
    row(lambda: CarriageMove(gust=(0.1, 2.0, 1.0)), "gust"),
    row(lambda: move_carriage(replace(LINE, motor=None)), "motor"),
    row(
        lambda: move_carriage(replace(LINE, sensors=replace(LINE.sensors, load_encoder=None))), "load_encoder"
    ),
    *(
        row(
            lambda name=name: transporter_of(cd.load_drive(name).listed, payload_mass=0.1, line_length=0.1),
            "carriage",
        )
        for name in ("dissertation-1", "elevator")
    ),
]
SPECS = [
    row(lambda: parse_disturbance("load:nan:0.1:0.2"), "nan"),
    row(lambda: parse_disturbance("load:0.05:0.2:0.1"), "0.2", "0.1"),
    row(lambda: parse_encoder_dropout("load:0.2:0.1"), "swap"),
    row(lambda: parse_payload_range("3"), "LOW:HIGH", "3"),
    row(lambda: Motion(payload=WIDE.payload), "payload", "3.5", "0.5 to 3", "--payload-range"),
    row(lambda: Motion(payload_range=(1.5, 3.0)), "payload_range", "1.5 to 3", "1"),
    row(lambda: Payload(factor=-1.0), "payload", "-1", "above 0"),
    row(lambda: Payload(factor=2.0, start=-1.0), "payload", "-1 s"),
    row(lambda: disturbances_of({"load_friction": 1.0}), "load_friction"),
    row(lambda: disturbances_of({"backlash": "1 N m"}), "backlash", "N m", "rad"),
    row(lambda: disturbances_of({"load_factor": [3, 0.5]}), "load_factor"),
    row(lambda: disturbances_of({"load_factor": [1, 2, 3]}), "load_factor", "3 values"),
    row(lambda: disturbances_of({"torque_ripple": 2.0}), "torque_ripple", "0 to 1"),
    row(late_plant, "added_delay"),
    row(unmade_law(feedforward="rigid"), "darc-4", "feedforward"),
    row(lambda: design("pd", DesignSpec(DRIVE, Motion(), feedforward="perfect")), "feedforward", "perfect"),
]


@pytest.mark.parametrize("call, named", [*RUNS, *WINCHES, *CARRIAGES, *SPECS])
def test_what_cannot_be_run_is_refused_in_one_line_that_names_it(call, named):
    refused(call, *named)


def late(value):
    """Right for a hundred samples, then the value as a command."""
    count = iter(range(10**6))

    def step(gains, state, measurement, reference):
        return state, (reference[-1] if next(count) < 100 else value)

    return step


def held(gains, state, measurement, reference):
    return state, reference[-1]


@numba.njit
def unknown(gains, state, measurement, reference):
    return state, reference.no_such_thing


@numba.njit
def growing(gains, state, measurement, reference):
    return state * 1e30 + 1e30, state[0]


@pytest.mark.parametrize(
    "parts, named",
    [
        ({"step": late(np.nan), "name": "broken"}, ["broken", "nan", "sample 100", "0.02 s"]),
        ({"step": late(np.zeros(2))}, ["shape (2,)", "sample 100"]),
        ({"step": late("fast")}, ["sample 100", "numbers"]),
        ({"step": lambda g, s, m, r: (np.zeros(3), 0.0)}, ["(3,)", "(0,)", "initial_state"]),
        ({"step": lambda g, s, m, r: 0.0}, ["(state, command)"]),
        ({"step": lambda g, s, m, r: (s * np.nan, 0.0), "initial_state": [1.0]}, ["state", "finite"]),
        ({"step": growing, "initial_state": [1.0], "name": "fifty"}, ["fifty", "finite", "sample"]),
        ({"step": unknown}, ["own controller"]),
        ({"initial_state": [[1.0]]}, ["initial_state"]),
        ({"initial_state": "no"}, ["initial_state"]),
        ({"sample_time": 1e-3}, ["sample_time", "0.001 s", "0.0002 s"]),
        ({"sample_time": "fast"}, ["sample_time"]),
        ({"shafts": ("load", "motor")}, ["shafts", "motor, drive, load"]),
        ({"measures": "tension"}, ["measures", "states", "readings"]),
        ({"follows": 3}, ["follows", "inverse", "motion"]),
        ({"name": "lqg"}, ["lqg", "packaged"]),
        ({"name": ""}, ["name"]),
    ],
)
def test_what_an_own_controller_must_not_return_or_be_is_named(parts, named):
    given = SimpleNamespace(**({"step": held, "gains": np.zeros(6)} | parts))
    refused(lambda: track(DRIVE, controller=given, motion=SHORT), *named)


def own_plant(**parts):
    given = {"step": lambda p, s, u, t: s, "initial_state": np.zeros(4), "shafts": ("motor", "drive")}
    return cd.OwnPlant(**(given | {"name": "two masses", "parameters": 0.0} | parts))


def chain(**parts):
    """Motor, a gear's shaft, drive pulley and load."""
    given = {name: (0.0,) * 4 for name in ("viscous", "coulomb", "offsets")}
    given |= {"inertias": (1e-3,) * 4, "stiffness": (900.0, 135.0, 2.7), "damping": (0.1,) * 3}
    names = {"names": ("motor", "gear", "drive", "load"), "ratios": ((1.0, 1.0),) * 3}
    return cd.LumpedChain(**(given | names | parts))


@pytest.mark.parametrize(
    "plant, named",
    [
        (own_plant(step=lambda p, s, u, t: s[:2]), ["two masses", "shape (2,)", "sample 0"]),
        (own_plant(step=lambda p, s, u, t: s * np.nan), ["two masses", "not finite", "sample 0"]),
        (own_plant(step=lambda p, s, u, t: "no"), ["two masses", "sample 0"]),
        (own_plant(initial_state=np.zeros(3)), ["initial_state", "2 angles"]),
        (own_plant(shafts=("motor", "gear")), ["shafts", "gear", "('motor', 'load')"]),
        (5, ["plant = 5", "OwnPlant"]),
        (held, ["plant", "OwnPlant"]),
        (cd.OwnPlant, ["plant", "OwnPlant"]),
        ("model-7", ["model-7", "model-1"]),
        (chain(holding=3.0), ["holding", "3"]),
        (chain(names=("motor", "gear", "pulley", "load")), ["drive"]),
        (chain(names=("a", "b", "drive", "d")), ["motor", "load"]),
        (chain(ratios=((1.0, 1.0), (1.0, 1.0), (1.0, 3.0))), ["3", "r2 / r1"]),
    ],
)
def test_a_plant_that_does_not_fit_is_named(plant, named):
    refused(lambda: track(LINEAR, controller="pd", plant=plant, motion=SHORT), *named)


OWN = cd.OwnController(step=held, gains=np.zeros(6))
SMOOTHED = RigOptions(smooth_friction=True)


@pytest.mark.parametrize(
    "choices, named",
    [
        *(
            ({"controller": given}, "OwnController")
            for given in (held, 7, cd.OwnController, object(), ["pd"])
        ),
        ({"controller": OWN, "bandwidth": 5.0}, "bandwidth"),
        ({"controller": OWN, "adapt": False}, "adapt"),
        ({"controller": "pd", "plant": own_plant(), "draws": 3}, "draws"),
        ({"controller": "pd", "plant": own_plant(), "options": SMOOTHED}, "smooth_friction"),
    ],
)
def test_what_is_no_controller_and_settings_that_parts_of_ones_own_do_not_have_are_named(choices, named):
    refused(lambda: track(LINEAR, motion=SHORT, **choices), named)


def controller_file(folder, law="pd", hertz=6.0, **changes):
    data = controller_numbers(loop_of(law, DRIVE, SHORT, bandwidth=hertz), DRIVE, "motor") | changes
    (folder / "controller.json").write_text(json.dumps(data))
    return folder / "controller.json"


@pytest.mark.parametrize(
    "changes, choices, named",
    [
        ({"drive_hash": "0" * 64}, {}, ["another drive", "000000000000", "drive.toml"]),
        ({"name": "no-such-law"}, {}, ["no-such-law", "pd"]),
        ({"sample_time": 1e-3}, {}, ["0.001 s", "0.0002 s"]),
        ({"encoders": ["motor", "load", "drive"]}, {}, ["encoders"]),
        ({"shafts": ["load"]}, {}, ["do not fit"]),
        ({"filter": {}}, {}, ["no controller", "kind"]),
        ({"radius": 1.0}, {}, ["carriage"]),
        ({"law": "lqi-learning", "hertz": 22.0, "reference": None}, {}, ["run the study again"]),
        ({}, {"bandwidth": 5.0}, ["bandwidth"]),
        ({}, {"gains": "dissertation"}, ["gains"]),
        ({}, {"options": IDEAL}, ["filter"]),
        ({}, {"feedforward": "rigid"}, ["feedforward"]),
    ],
)
def test_a_controller_file_that_does_not_fit_is_named(changes, choices, named, tmp_path):
    path = controller_file(tmp_path, **changes)
    refused(lambda: track(DRIVE, controller=path, motion=SHORT, **choices), *named)


@pytest.mark.parametrize("text", ["", "[1, 2]", "{}", '{"drive_hash": 1}', "\x00", "3", None])
def test_what_is_no_controller_file_is_named(text, tmp_path):
    path = tmp_path / "controller.json"
    if text is not None:
        Path(path).write_text(text)
    refused(lambda: track(DRIVE, controller=path, motion=SHORT), "controller.json")


@pytest.mark.parametrize("time", [0.01, 1.0, 10.0])
@pytest.mark.parametrize(("law", "least"), [("darc-2", 11.6), ("darc-4", 11.2), ("backstepping-6", 11.3)])
def test_the_least_bandwidth_of_a_law_is_that_of_the_drive(law, least, time):
    """12 Hz was that of `darc-2` on every drive, and from 200 Hz on no law was refused."""
    drive = in_other_units(DRIVE, (1.0, 1.0, time))
    moving = Motion(angle=5.0, rise=0.3 * time, dwell=0.1 * time, order=11)
    wanted = DesignSpec(drive, moving, bandwidth=0.9 * least / time)
    line = refused(lambda: design(law, wanted), f"Hz, where {law} is unstable on this drive")
    assert float(line.split("below ")[1].split()[0]) * time == pytest.approx(least, rel=0.015)
    assert design(law, replace(wanted, bandwidth=1.1 * least / time)).name == law


def test_a_law_that_no_bandwidth_makes_stable_is_refused():
    slow = replace(DRIVE, sensors=replace(DRIVE.sensors, sample_rate=200.0))
    wanted = DesignSpec(slow, Motion(order=11), bandwidth=4.0)
    refused(lambda: design("darc-2", wanted), "darc-2 is unstable on this drive", "up to 10 Hz")
