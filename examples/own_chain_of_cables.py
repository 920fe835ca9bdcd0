"""What are the modes of three different cables in a row, with a flexible mount at each end?

Steel, belt, steel, joined at sleeves: rigidity and density for each segment, motor and tool as pendants."""

import numpy as np

import cabledrive as cd
from cabledrive.mechanics import Chain, Pendant

cables = {"rigidity": np.array([9.0e4, 1.2e4, 9.0e4]), "density": np.array([0.010, 0.012, 0.010])}  # N, kg/m
motor, tool = Pendant(stiffness=4e4, mass=0.6), Pendant(stiffness=2e4, mass=0.3, joint=3)
masses, lengths = np.array([0.2, 0.01, 0.01, 0.9]), np.array([0.8, 0.5, 0.4])  # kg, m
found = cd.modes(Chain(**cables, lengths=lengths, masses=masses, pendants=(motor, tool)), count=6)
for mode in found.modes:
    print(f"{mode.frequency:8.2f} Hz, moves most:", max(mode.kinetic_shares, key=mode.kinetic_shares.get))
assert found.certified
assert abs(found.modes[0].frequency - 26.41) < 0.01  # Hz
