"""How much does a gear stage that the law leaves out cost?

A plant of four inertias in angles of the motor's shaft, under the law of three (Model 4)."""

import cabledrive as cd

gearbox = cd.LumpedChain(
    names=("motor", "gear", "drive", "load"), inertias=(8e-4, 3e-4, 6.42e-4, 2.35e-3),  # kg m^2
    viscous=(3.1e-3, 0.0, 0.0, 0.0), coulomb=(0.0376, 0.0, 0.0, 0.0), offsets=(-6e-4, 0.0, 0.0, 0.0),
    stiffness=(400.0, 200.0, 2.72), damping=(0.075, 0.075, 0.0144), ratios=((1.0, 1.0),) * 3,  # N m/rad
)  # fmt: skip
drive = cd.load_drive("dissertation-3")
errors = [cd.track(drive, plant=plant).summary["peak_error_deg"] for plant in (None, gearbox)]
print(f"peak error {errors[0]:.4f} deg on Model 4, {errors[1]:.4f} deg with the gear stage")
assert abs(errors[1] - errors[0]) < 0.02
