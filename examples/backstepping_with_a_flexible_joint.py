"""What does a flexible motor joint in the design buy a backstepping law?

The law of four states knows the cable only; the one of six states knows the joint as well, runs at more than
twice the bandwidth, and misses by less than half. Its sufficient condition of stability is looked at, too.
"""

import numpy as np

import cabledrive as cd
from cabledrive.control.backstepping import stability_margin
from cabledrive.rig import Motion, track
from cabledrive.rig.laws.baselines import backstepping
from cabledrive.rig.laws.controllers import DesignSpec

drive, pulse = cd.load_drive("dissertation-3").two_pulleys, Motion(order=9)
peaks = {}
for law in ("backstepping", "backstepping-6"):
    run = track(drive, controller=law, motion=pulse, gains="dissertation", seed=0)
    peaks[law] = run.summary["peak_error_deg"]
    print(f"{law:15s} {run.summary['gains']['bandwidth_hz']:5.1f} Hz  peak error {peaks[law]:.3f} deg")

made = backstepping(DesignSpec(drive, pulse), number=4)
k = 1000  # 0.2 s into the pulse
states = np.concatenate((run.angles[k], run.speeds[k]))
margin = stability_margin(made.law, run.estimates[k], states, made.reference[k])
print(f"smallest eigenvalue of D_z with adaptation: {margin:.2e} 1/s")

assert peaks["backstepping-6"] < 0.08
assert peaks["backstepping-6"] < 0.6 * peaks["backstepping"]
assert margin < 0.0  # sufficient, and not met
