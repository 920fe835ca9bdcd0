"""How does a part that the package does not know enter the modes? An inerter between two masses, as one row.

An inerter resists with the difference of the accelerations of its ends. In the table of rows it is a mass
whose row is that difference; counting, refining and proving need to know no more.
"""

from dataclasses import replace
from math import pi, sqrt

from cabledrive.mechanics import Chain
from cabledrive.mechanics.chain import own_chain
from cabledrive.modal.component import Fixed
from cabledrive.modal.networks import network_of_chain
from cabledrive.modal.rows import MASS
from cabledrive.modal.spectrum import Spectrum

line = Chain(rigidity=1000.0, density=1e-9, lengths=[1.0], masses=[1.0, 2.0])  # N, kg/m, m, kg
network = network_of_chain(own_chain(line))
inerter = Fixed(MASS, 0.5, ((0, 1.0), (1, -1.0)))  # kg; the motion of joint 0 less that of joint 1
network = replace(network, fixed=(*network.fixed, inerter))

(mode,) = Spectrum(network).below(2 * pi * 100.0)
expected = sqrt(1000.0 / (2.0 / 3.0 + 0.5)) / (2 * pi)  # reduced mass and inerter against the spring
print(f"{mode.frequency:.6f} Hz, by hand {expected:.6f} Hz")
assert abs(mode.frequency - 4.659580) < 1e-6
