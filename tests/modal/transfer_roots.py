r"""Natural frequencies to forty digits from transfer matrices: no dynamic stiffness, no inertia count.

With :math:`y = F/(\omega Z)` a wave turns (u, y) by :math:`\alpha = \omega l/c`, a mass shears it by
:math:`y \to y - \omega (m/Z) u`. Lines: the angle of (u, y) grows with frequency and takes a fixed value at
each mode (Sturm and Pruefer), so mode number j is the root of a monotone function. Rings: the modes are the
zeros, with their order, of the discriminant :math:`a + d - 2 - b\,\omega M` (Hill), one in each gap between
the modes of the ring held at its first joint. The drive's figures enter exactly as the floats they are.
"""

from dataclasses import dataclass
from itertools import pairwise

from mpmath import mp, mpf

DIGITS = 110
_ROOT = mpf(10) ** -48
_ORDER = mpf(10) ** -25


@dataclass(frozen=True)
class ExactChain:
    """Travel times, masses over impedance [s]; the pendant's frequency [rad/s] and mass over impedance."""

    times: list
    masses: list
    closed: bool = False
    fixed: tuple = (False, False)
    pendant: tuple | None = None
    pendant_joint: int = 0

    def shear(self, joint, omega):
        """What a joint takes from y per u, times (1 - (omega/omega_p)^2) at the pendant's joint."""
        if self.pendant is None or joint != self.pendant_joint:
            return omega * self.masses[joint]
        own, mass = self.pendant
        return omega * (self.masses[joint] * (1 - (omega / own) ** 2) + mass)

    def detuning(self, joint, omega):
        if self.pendant is None or joint != self.pendant_joint:
            return mpf(1)
        return 1 - (omega / self.pendant[0]) ** 2


@mp.workdps(DIGITS)
def exact_chains(drive):
    """The longitudinal chains of a drive, put together from its data alone."""
    rigidity = mpf(drive.cable.youngs_modulus) * mpf(drive.cable.area)
    density = mpf(drive.cable.mass_per_length)
    speed, impedance = mp.sqrt(rigidity / density), mp.sqrt(rigidity * density)
    radii = [mpf(p.radius) for p in drive.pulley]
    inertias = [mpf(p.inertia) for p in drive.pulley]
    pendant = None
    if drive.motor is not None and drive.motor.joint_stiffness is None:
        inertias[0] += mpf(drive.motor.inertia)
    elif drive.motor is not None:
        own = mp.sqrt(mpf(drive.motor.joint_stiffness) / mpf(drive.motor.inertia))
        pendant = own, mpf(drive.motor.inertia) / radii[0] ** 2 / impedance
    drive_mass, load_mass = (j / r**2 / impedance for j, r in zip(inertias, radii, strict=True))
    length = mpf(drive.layout.span_length)
    gaps, carried = {}, {}
    for span in drive.spans:
        places = [mpf(0), *(mpf(c.position) for c in drive.carriages_on(span)), length]
        gaps[span] = [(b - a) / speed for a, b in pairwise(places)]
        carried[span] = [mpf(c.mass) / impedance for c in drive.carriages_on(span)]
    first, second = (p.fixed for p in drive.pulley)
    upper = [drive_mass, *carried["upper"], load_mass]
    if drive.kind == "line":
        return [ExactChain(gaps["upper"], upper, fixed=(first, second), pendant=pendant)]
    lower = [load_mass, *carried["lower"], drive_mass]
    if first and second:
        return [ExactChain(gaps[s], m, fixed=(True, True)) for s, m in (("upper", upper), ("lower", lower))]
    if first:
        times, masses = gaps["upper"] + gaps["lower"], upper + lower[1:]
        return [ExactChain(times, masses, fixed=(True, True))]
    if second:
        times, masses = gaps["lower"] + gaps["upper"], lower + upper[1:]
        joint = len(lower) - 1
        return [ExactChain(times, masses, fixed=(True, True), pendant=pendant, pendant_joint=joint)]
    times, masses = gaps["upper"] + gaps["lower"], upper + lower[1:-1]
    return [ExactChain(times, masses, closed=True, pendant=pendant)]


@mp.workdps(DIGITS)
def exact_roots(drive, count):
    """The first natural angular frequencies of a drive, multiple ones repeated, no rigid-body mode."""
    roots = []
    for chain in exact_chains(drive):
        lines = (_line_root(chain, j) for j in range(1, count + 1))
        roots += _ring_roots(chain, count) if chain.closed else lines
    return sorted(roots)[:count]


def angle(chain, omega):
    """Angle of (u, y) at the end of a line, counted on over full turns."""
    turns, u, y = (0, mpf(0), mpf(1)) if chain.fixed[0] else (0, mpf(1), mpf(0))
    last = len(chain.masses) - 1
    for joint in range(last + 1):
        if not (joint == 0 and chain.fixed[0]) and not (joint == last and chain.fixed[1]):
            detuning = chain.detuning(joint, omega)
            u, y = u * detuning, y * detuning - chain.shear(joint, omega) * u
            if detuning < 0:  # the vector has turned past u = 0 once more
                turns, u, y = turns + 1, -u, -y
        if joint < last:
            turns, u, y = _turn(turns, u, y, omega * chain.times[joint])
    return turns * mp.pi + mp.atan2(u, y)


def _turn(turns, u, y, alpha):
    """Turn (u, y), whose angle lies in [0, pi), by alpha; count half turns."""
    half_turns = int(mp.floor((mp.atan2(u, y) + alpha) / mp.pi))
    c, s = mp.cos_sin(alpha)
    sign = -1 if half_turns % 2 else 1
    return turns + half_turns, sign * (u * c + y * s), sign * (y * c - u * s)


def _line_root(chain, number):
    """Mode `number` of a line, from 1, the rigid-body mode left out."""
    target = number * mp.pi if chain.fixed[1] else (number + mpf(1) / 2 - chain.fixed[0]) * mp.pi
    return increasing_root(lambda omega: angle(chain, omega) - target, mp.pi / sum(chain.times))


def increasing_root(f, start):
    """Root of an increasing function of a positive variable."""
    low, high = start, start
    while f(high) < 0:
        high *= 2
    while f(low) >= 0:
        low /= 2
    return bracketed_root(f, low, high)


def bracketed_root(f, low, high):
    """Bisection, then Anderson and Bjorck's regula falsi held to halving in every third step."""
    f_low, f_high = f(low), f(high)
    step = 0
    while high - low > _ROOT * high:
        step += 1
        width = high - low
        middle = (low + high) / 2
        if width < high / 1000 and step % 3:
            middle = (low * f_high - high * f_low) / (f_high - f_low)
            edge = _ROOT * high / 4
            middle = min(max(middle, low + edge), high - edge)
        value = f(middle)
        if value == 0:
            return middle
        if (value < 0) == (f_low < 0):
            low, f_low, f_high = middle, value, f_high * _share(value, f_low)
        else:
            high, f_high, f_low = middle, value, f_low * _share(value, f_high)
    return (low + high) / 2


def _share(value, before):
    share = 1 - value / before
    return share if share > 0 else mpf(1) / 2


def _ring_roots(chain, count):
    """Zeros of the discriminant, one between each two neighbouring modes of the ring held at joint 0."""
    held = ExactChain(chain.times, [*chain.masses, mpf(0)], fixed=(True, True))
    poles = [_line_root(held, j) for j in range(1, count + 2)]
    if chain.pendant is not None:
        poles = sorted([*poles, chain.pendant[0]])[: count + 1]
    roots = []
    before = None
    for pole in poles:
        above, beyond = (discriminant(chain, pole * (1 + h * _ORDER)) for h in (1, 2))
        below = discriminant(chain, pole * (1 - _ORDER))
        if before is not None and pole - before[0] <= 4 * _ORDER * pole:
            continue  # two poles in one place: the order of the zero there holds both
        if before is not None and (before[1] < 0) != (below < 0):
            low, high = before[0] * (1 + _ORDER), pole * (1 - _ORDER)
            roots.append(bracketed_root(lambda omega: discriminant(chain, omega), low, high))
        roots += [pole] * int(mp.nint(mp.log(abs(beyond / above), 2)))
        before = pole, above
    for root, low, high in zip(roots, poles, poles[1:], strict=False):
        assert low * (1 - 4 * _ORDER) <= root <= high * (1 + 4 * _ORDER), "the reference lost a root"
    assert len(roots) >= len(poles) - 1, "the reference lost a root"
    return roots[:count]


def discriminant(chain, omega):
    """Zero, in the order of its multiplicity, where a ring has a mode; entire."""
    a, b, c, d = mpf(1), mpf(0), mpf(0), mpf(1)  # columns: what (u, y) = (1, 0) and (0, 1) have become
    for joint, time in enumerate(chain.times):
        if joint:
            shear = chain.shear(joint, omega)
            c, d = c - shear * a, d - shear * b
        cosine, sine = mp.cos_sin(omega * time)
        a, b, c, d = (
            a * cosine + c * sine,
            b * cosine + d * sine,
            c * cosine - a * sine,
            d * cosine - b * sine,
        )
    return (a + d - 2) * chain.detuning(0, omega) - b * chain.shear(0, omega)


@mp.workdps(30)
def winding_number(chain, low, high):
    """Zeros of the discriminant between two frequencies, by the change of its argument round a rectangle."""
    depth = mpf(1) / sum(chain.times)
    corners = [mp.mpc(low, -depth), mp.mpc(high, -depth), mp.mpc(high, depth), mp.mpc(low, depth)]
    change = sum(_change(chain, a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True))
    return int(mp.nint(change / (2 * mp.pi)))


def _change(chain, start, end):
    """Change of the discriminant's argument along a line, cut until a piece turns by half a radian."""

    def turned(start, end, first, last):
        middle = (start + end) / 2
        between = discriminant(chain, middle)
        parts = mp.arg(between / first), mp.arg(last / between)
        if max(map(abs, parts)) < 0.5:
            return sum(parts)
        return turned(start, middle, first, between) + turned(middle, end, between, last)

    places = [start + k * (end - start) / 32 for k in range(33)]
    ends = pairwise(zip(places, [discriminant(chain, place) for place in places], strict=True))
    return sum(turned(a, b, first, last) for (a, first), (b, last) in ends)
