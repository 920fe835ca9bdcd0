"""What `modes` and what is made of them refuse: each row a call, and what its one line names."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.mechanics import Chain, Pendant
from cabledrive.modal.lowest import against_lumped_springs
from cabledrive.modal.tuning import tuned_pretension

LOOP = cd.load_drive("dissertation-1")
HELD = replace(LOOP, pulley=tuple(replace(pulley, fixed=True) for pulley in LOOP.pulley))
FAST = Path(__file__).parent.parent / "parameters" / "routes" / "serpentine.toml"
MOTOR = Pendant(stiffness=2500.0, mass=0.4, joint=2)
LINE = Chain(
    rigidity=438.0,
    density=2.1e-4,
    lengths=np.array([0.6, 0.37, 0.47]),
    masses=np.array([0.8, 0.05, 0.2, 1.5]),
)
LIMITS = [
    *(({"below": below}, ["below = "]) for below in (0.0, -1.0, np.nan, np.inf)),
    *(({"below": below}, ["lower it to about"]) for below in (1e7, 1e30)),
    *(({"below": below}, ["must lie between"]) for below in (1e308, 1e-300, 5e-324)),
    *(({"count": count}, ["count = ", "1 and 20000"]) for count in (0, 10**6)),
]
HOLDING = [
    ({"motor": "stuck"}, ["free, held or holding"]),
    ({"motor": "holding"}, ["motor.holding_stiffness"]),
    ({"hold": ["carriage 1"]}, ['did you mean "carriage 0"']),
    ({"hold": ["motor"]}, ['motor = "held"']),
]
CHAINS = [
    ({"rigidity": np.array([1.0, -3.0, 1.0])}, ["segment 1", "rigidity", "-3 N", "positive"]),
    ({"density": np.array([1.0, 2.0])}, ["density", "2 values", "3 segments"]),
    ({"lengths": np.array([0.1, np.nan, 0.1])}, ["segment 1", "length", "nan m", "finite"]),
    ({"grounds": np.array([0.0, 0.0, -1.0, 0.0])}, ["joint 2", "grounds", "-1 N/m"]),
    ({"pendants": (replace(MOTOR, joint=4),)}, ["pendant 0", "joint = 4", "0 to 3"]),
    ({"pendants": (MOTOR, replace(MOTOR, mass=0.0))}, ["pendant 1", "mass", "0 kg", "positive"]),
]
ROWS = [
    *((lambda given=given: cd.modes(LOOP, **given), named) for given, named in LIMITS),
    *(
        (lambda given=given: cd.modes(cd.load_drive("linear-axis"), **given), named)
        for given, named in HOLDING
    ),
    *((lambda given=given: cd.modes(replace(LINE, **given)), named) for given, named in CHAINS),
    (lambda: cd.modes(LINE, motor="held"), ["about drives"]),
    (lambda: cd.modes(LINE, hold=["joint 0"]), ["about drives"]),
    (lambda: cd.modes(LINE, at_torque=1.0), ["about drives"]),
    (lambda: cd.modes(cd.load_drive(FAST, overrides=["route.belt.speed=60"])), ["reaches the wave speed"]),
    (lambda: tuned_pretension(HELD), ["no pulley turns"]),
    (lambda: against_lumped_springs(HELD), ["fixed"]),
]


@pytest.mark.parametrize(("call", "named"), ROWS)
def test_what_has_no_modes_is_refused_in_one_line_that_names_it(call, named):
    with pytest.raises(cd.InputRefused) as refused:
        call()
    words = str(refused.value)
    assert "\n" not in words
    assert all(part in words for part in named), words
