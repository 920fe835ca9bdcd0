"""Which pretension keeps a drive clear of its 2:1 resonance between pulleys and cable?

When the lowest transverse frequency is half of the lowest longitudinal one, turning the pulleys
shakes the cable sideways: chapter 5 of the dissertation. Its rig is tuned so at 3.284 N;
here that is found, and the band around it in which the two frequencies are within 5 % of the ratio.
"""

from scipy.optimize import brentq

import cabledrive as cd


def frequency_ratio(pretension: float) -> float:
    """Lowest transverse over lowest longitudinal frequency."""
    drive = cd.load_drive("dissertation-2", overrides=[f"cable.pretension={pretension!r}"])
    found = cd.modes(drive, count=1)
    return found.transverse[0].frequency / found.longitudinal[0].frequency


def pretension_for(ratio: float) -> float:
    """Pretension [N] at which the two have this ratio."""
    return float(brentq(lambda tension: frequency_ratio(tension) - ratio, 0.5, 50.0, xtol=1e-10))


for tension in (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0):
    print(f"{tension:4.1f} N   ratio {frequency_ratio(tension):.3f}")
low, tuned, high = (pretension_for(0.5 * share) for share in (0.95, 1.0, 1.05))
print(f"ratio 1/2 at {tuned:.4f} N: stay below {low:.2f} N or above {high:.2f} N")

assert abs(tuned - 3.284) < 5e-4, f"{tuned} N"
