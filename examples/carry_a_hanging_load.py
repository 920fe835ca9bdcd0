"""A carriage of half a kilogram travels a metre, and a load swings below it: what is left at the end?

PD with rigid feedforward leaves 83 mm of swing. The inverse of the flexible machine leaves a millimetre, but
it knows no wind; a law whose gains follow the carriage along the cable damps what a gust has done.
"""

import cabledrive as cd
from cabledrive.rig import CarriageMove, move_carriage
from cabledrive.studies.transporter_moves import along_the_way, scaled_transporter

drive = scaled_transporter(cd.load_drive("dissertation-transporter"))
windy = CarriageMove(gust=(0.2, 1.0, 1.5))
left = {}
for law in ("pd", "pd-flat", "scheduled"):
    left[law] = (
        move_carriage(drive, law).residual(),
        move_carriage(drive, law, move=windy).residual(later=2.0),
    )
    print(f"{law:10s} still air {1e3 * left[law][0]:6.2f} mm, 2 s after a gust {1e3 * left[law][1]:6.2f} mm")

growth = along_the_way(drive, positions=8, laws=("scheduled",)).growth["scheduled"]
print(f"slowest pole along the way: {growth.max():.2f} 1/s")

assert left["scheduled"][0] < 0.2 * left["pd"][0]
assert left["scheduled"][1] < 0.1 * left["pd-flat"][1]
assert growth.max() < 0.0
