"""How the lowest frequency of a lift changes as the car travels, empty and with a full load.

If the ropes had no mass the half-loaded car 30 m below the sheave would move at 3.606 Hz; they weigh 828 kg.
"""

from dataclasses import replace

import cabledrive as cd

lift = cd.load_drive("elevator").two_pulleys


def lowest_frequency(depth: float, car_mass: float) -> float:
    """The car so many metres below the traction sheave; the counterweight is as far above the pit."""
    car, counterweight = lift.carriage
    moved = (replace(car, position=depth, mass=car_mass), replace(counterweight, position=depth))
    return float(cd.natural_frequencies(replace(lift, carriage=moved), count=1)[0])


loads = {"empty": 2000.0, "half": 2637.5, "full": 3275.0}
print("depth [m]   " + "   ".join(f"{load:>8}" for load in loads))
for depth in (5.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0):
    row = [lowest_frequency(depth, mass) for mass in loads.values()]
    print(f"{depth:9.0f}   " + "   ".join(f"{f:5.3f} Hz" for f in row))

half_loaded = lowest_frequency(30.0, loads["half"])
print(f"30 m deep, half loaded: {half_loaded:.4f} Hz, {1 - half_loaded / 3.606:.1%} below ropes without mass")
assert 0.97 < half_loaded / 3.606 < 1.0, f"{half_loaded} Hz"
