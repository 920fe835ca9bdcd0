"""Which input shaper does a printer need whose head rings at two frequencies?

A shaper for one of them leaves the other. Here the test of an axis is computed for a head with modes at 48
and 83 Hz, written as the firmware writes it, and read again: ZV leaves a quarter of the vibration, a wider
shaper next to none, and it rounds corners more.
"""

import numpy as np

import cabledrive as cd
from cabledrive.trajectories import residual_vibration

MODES = ((48.0, 0.06, 1.0), (83.0, 0.04, 0.5))  # Hz, damping ratio, share

frequency = 1.5625 * np.arange(128)
head = sum(share / (1 - (frequency / f) ** 2 + 2j * z * frequency / f) for f, z, share in MODES)
density = 100.0 * (frequency * np.abs(head)) ** 2
with open("resonances_x_example.csv", "w") as file:
    file.write("freq,psd_x,psd_y,psd_z,psd_xyz\n")
    for f, x in zip(frequency, density, strict=True):
        file.write(f"{f:.1f},{x:.3e},0,0,{x:.3e}\n")

found = cd.shaper("resonances_x_example.csv")
for fit in found.shapers:
    print(
        f"{fit.type:9} {fit.frequency:6.1f} Hz  leaves {100 * fit.vibration:4.1f} %  "
        f"smoothing {1e3 * fit.smoothing:.3f} mm  up to {fit.max_acceleration:.1f} m/s^2"
    )
print(found.configuration)

best = found.recommended
assert found.shapers[0].type == "zv"
assert best.type != "zv"
assert 0.2 < found.shapers[0].vibration < 0.3
left = [float(residual_vibration(best.shaper, np.array([f]), z)[0]) for f, z, _ in MODES]
print(f"behind it the two modes keep {100 * left[0]:.1f} and {100 * left[1]:.1f} % of their amplitude")
assert max(left) < 0.2, left
