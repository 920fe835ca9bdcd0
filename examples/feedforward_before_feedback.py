"""How much of a controller's merit is its feedforward?

The same PD on the motor's encoder follows the same pulse with three feedforwards: of a rigid machine, of the
exact inverse without the cable's damper, and with it. Then the damping-aware law at the gains that the
package chooses. The rigid feedforward misses by two degrees, whatever feedback stands behind it.
"""

import cabledrive as cd
from cabledrive.rig import track

drive = cd.load_drive("dissertation-3")
peaks = {}
for feedforward in ("rigid", "undamped", "damped"):
    said = track(drive, controller="pd", bandwidth=11.0, feedforward=feedforward).summary
    peaks[feedforward] = said["peak_error_deg"]
    print(f"PD at 11 Hz, {said['gains']['feedforward']:45s} {said['peak_error_deg']:.3f} deg")

best = track(drive, controller="darc-4-damped", gains="best").summary
print(f"damping-aware law, best gains {best['peak_error_deg']:27.3f} deg")
print("\n".join(best["gains"]["reasons"]))

assert peaks["rigid"] > 1.5, peaks
assert best["peak_error_deg"] < 0.041, best["peak_error_deg"]
