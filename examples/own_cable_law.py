"""How do I put in a cable law of my own?

One class with one method: the components of the tension from the displacement gradients, in numpy. This cable
is half as stiff where it shortens, so that a loop of two spans twists 4/3 as far under the same slow torque.
"""

import numpy as np

import cabledrive as cd


class Bilinear(cd.CableLaw):
    def components(self, u_x, v_x, w_x):
        stretch = np.sqrt((1.0 + u_x) ** 2 + v_x**2 + w_x**2)
        strain = stretch - 1.0
        tension = self.pretension + self.stiffness * np.where(strain > 0.0, strain, 0.5 * strain)
        return tension * (1.0 + u_x) / stretch, tension * v_x / stretch, tension * w_x / stretch


run = {"drive": cd.load_drive("dissertation-2"), "duration": 0.1}
run["torque"] = lambda time: 0.1 * (1.0 - np.cos(20.0 * np.pi * time))  # N m
hooke, own = (cd.simulate(**run, model=model) for model in ("exact", Bilinear))
twist, expected = (np.mean(result.drive_angle - result.load_angle) for result in (own, hooke))
print(own, f"mean twist: {twist / expected:.3f} times that of the exact law", sep="\n")

assert abs(twist / expected - 4.0 / 3.0) < 0.01, twist / expected
