"""A carriage of half a kilogram travels a metre, and a load swings below it: what is left at the end?

PD with rigid feedforward leaves 83 mm of swing. The inverse of the flexible machine leaves a millimetre, but
it knows no wind; a law whose gains follow the carriage along the cable damps what a gust has done.
"""

from dataclasses import replace

import cabledrive as cd
from cabledrive.parameters import Motor
from cabledrive.rig import CarriageMove, move_carriage

given = cd.load_drive("dissertation-transporter").two_pulleys
drive = replace(
    given,
    cable=replace(given.cable, pretension=10.0, axial_damping=5e-4 * given.cable.axial_rigidity),
    layout=replace(given.layout, span_length=1.5),
    carriage=(replace(given.carriage[0], mass=0.5, position=0.25),),
    motor=Motor(inertia=0.0011, viscous_friction=0.0031, coulomb_friction=0.0376, torque_limit=2.1),
    sensors=replace(given.sensors, sample_rate=5000.0),
)
windy = CarriageMove(gust=(0.2, 1.0, 1.5))
left = {}
for law in ("pd", "pd-flat", "scheduled"):
    left[law] = (
        move_carriage(drive, law).residual(),
        move_carriage(drive, law, move=windy).residual(later=2.0),
    )
    print(f"{law:10s} still air {1e3 * left[law][0]:6.2f} mm, 2 s after a gust {1e3 * left[law][1]:6.2f} mm")

assert left["scheduled"][0] < 0.2 * left["pd"][0]
assert left["scheduled"][1] < 0.1 * left["pd-flat"][1]
