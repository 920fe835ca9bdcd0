"""Natural frequencies to fifty digits, from the discriminant of a ring's transfer matrix."""

from mpmath import mp, mpf

from cabledrive.mechanics.chain import Chain


def exact_frequency(ring: Chain, omega: float) -> float:
    """The simple natural frequency of a ring nearest to one that is known to about ten digits [rad/s]."""
    with mp.workdps(80):
        f = _discriminant(ring)
        a, b = mpf(omega) * (1 + mpf(10) ** -12), mpf(omega)
        f_a, f_b = f(a), f(b)
        for _ in range(8):
            if f_b == f_a or abs(b - a) < mpf(10) ** -50 * b:
                break
            a, f_a, b = b, f_b, b - f_b * (b - a) / (f_b - f_a)
            f_b = f(b)
        return float(b)


def _discriminant(ring: Chain):
    rigidity, density = mpf(ring.rigidity), mpf(ring.density)
    speed, impedance = mp.sqrt(rigidity / density), mp.sqrt(rigidity * density)
    times = [mpf(float(length)) / speed for length in ring.lengths]
    masses = [mpf(float(mass)) / impedance for mass in ring.masses]

    def value(omega):
        a, b, c, d = mpf(1), mpf(0), mpf(0), mpf(1)
        for time, mass in zip(times, masses, strict=True):
            c, d = c - omega * mass * a, d - omega * mass * b
            cosine, sine = mp.cos_sin(omega * time)
            a, c = a * cosine + c * sine, c * cosine - a * sine
            b, d = b * cosine + d * sine, d * cosine - b * sine
        return a + d - 2

    return value
