"""The two loops behind every count: plain arithmetic, run as Python for short chains, compiled for long ones.

Both eliminate joint after joint of the exact dynamic stiffness and count negative pivots (Sylvester) and the
modes hidden inside segments (Wittrick and Williams). A segment longer than 2 rad is cut on the fly as in
`split_at_antinodes`; ``inside`` counts the modes both parts hide. The readable oracle is
`cabledrive.modal.counting.modes_below_reference`.
"""

from collections.abc import Sequence
from math import floor, pi, tan

TINY = 1e-30


def count_line(
    omega: float,
    times: Sequence[float],
    masses: Sequence[float],
    springs: Sequence[float],
    impedance: float,
    spring: float,
    pendant_mass: float,
    pendant_ground: float,
    pendant_joint: int,
    first_fixed: bool,
    last_fixed: bool,
) -> int:
    """Modes of a line below omega: negative pivots from joint to joint, and modes inside segments.

    ``omega``: angular frequency [rad/s]; ``times``, ``masses``, ``springs``: travel times of the segments
    [s], masses of the joints [kg] and their springs to the ground [N/m]; ``impedance``: wave impedance
    [kg/s]; ``spring``, ``pendant_mass``, ``pendant_ground``: the pendant's stiffness [N/m], mass [kg] and
    stiffness to the ground [N/m]; 0 if there is none; ``pendant_joint``: where it hangs; ``first_fixed``,
    ``last_fixed``: whether the ends are held.
    """
    count = 0
    pendant = 0.0
    if spring > 0.0:
        behind = pendant_ground / omega - omega * pendant_mass
        pivot = spring / omega + behind
        if pivot == 0.0:
            pivot = TINY * spring / omega
        count += pivot < 0.0
        pendant = spring / omega * behind / pivot
    ground = springs[0] / omega - omega * masses[0] + (pendant if pendant_joint == 0 else 0.0)
    held = first_fixed
    for i in range(len(times)):
        phase = omega * times[i]
        parts = 1
        rest = 0.0
        if phase > 2.0:
            half_turns = floor(phase / pi + 0.5)
            whole = phase
            phase = (floor((half_turns - 1) / 2) + 0.5) * pi + (whole - half_turns * pi) / 2
            rest = whole - phase
            count += half_turns - 1
            parts = 2
        for part in range(parts):
            if part == 1:
                phase = rest
            half = tan(0.5 * phase)
            link = 0.5 * impedance * (half + 1.0 / half)
            edge = -impedance * half
            if held:
                ground = edge + link
                held = False
            else:
                pivot = link + (edge + ground)
                if pivot == 0.0:
                    pivot = TINY * abs(link)
                count += pivot < 0.0
                ground = edge + link * (edge + ground) / pivot
        ground += springs[i + 1] / omega - omega * masses[i + 1]
        ground += pendant if pendant_joint == i + 1 else 0.0
    if not last_fixed:
        count += ground < 0.0
    return count


def count_ring(
    omega: float,
    times: Sequence[float],
    masses: Sequence[float],
    springs: Sequence[float],
    impedance: float,
    spring: float,
    pendant_mass: float,
    pendant_ground: float,
    pendant_joint: int,
    second_cut: int,
) -> tuple[int, float]:
    """Modes of a ring below omega: both halves eliminated, the two joints between them counted last.

    ``omega``: angular frequency [rad/s]; ``times``, ``masses``, ``springs``: travel times of the segments
    [s], masses of the joints [kg] and their springs to the ground [N/m]; ``impedance``: wave impedance
    [kg/s]; ``spring``, ``pendant_mass``, ``pendant_ground``: the pendant's stiffness [N/m], mass [kg] and
    stiffness to the ground [N/m]; 0 if there is none; ``pendant_joint``: where it hangs; ``second_cut``:
    joint that parts the halves, joint 0 being the other one.
    Returns ``margin``: distance of the count from round-off, relative.
    """
    count = 0
    worst = 1.0
    pendant = 0.0
    if spring > 0.0:
        behind = pendant_ground / omega - omega * pendant_mass
        pivot = spring / omega + behind
        if pivot == 0.0:
            pivot = TINY * spring / omega
        count += pivot < 0.0
        pendant = spring / omega * behind / pivot
    n = len(times)
    total_link = 0.0
    ground_first = springs[0] / omega - omega * masses[0] + (pendant if pendant_joint == 0 else 0.0)
    ground_second = springs[second_cut] / omega - omega * masses[second_cut]
    ground_second += pendant if pendant_joint == second_cut else 0.0
    link = near = far = 0.0
    for i in range(n):
        joint_ground = springs[i] / omega - omega * masses[i] + (pendant if pendant_joint == i else 0.0)
        fresh = i == 0 or i == second_cut
        phase = omega * times[i]
        parts = 1
        rest = 0.0
        if phase > 2.0:
            half_turns = floor(phase / pi + 0.5)
            whole = phase
            phase = (floor((half_turns - 1) / 2) + 0.5) * pi + (whole - half_turns * pi) / 2
            rest = whole - phase
            count += half_turns - 1
            parts = 2
        for part in range(parts):
            if part == 1:
                phase = rest
                joint_ground = 0.0
            half = tan(0.5 * phase)
            new_link = 0.5 * impedance * (half + 1.0 / half)
            edge = -impedance * half
            if fresh:
                link, near, far = new_link, edge, edge
                fresh = False
            else:
                ground = far + edge + joint_ground
                pivot = link + new_link + ground
                if pivot == 0.0:
                    pivot = TINY * abs(new_link)
                count += pivot < 0.0
                clear = abs(pivot) / (abs(link) + abs(new_link) + abs(ground))
                if clear < worst:
                    worst = clear
                near += link * ground / pivot
                far = edge + new_link * ground / pivot
                link = link * new_link / pivot
        if i + 1 == second_cut:
            total_link += link
            ground_first += near
            ground_second += far
        elif i + 1 == n:
            total_link += link
            ground_second += near
            ground_first += far
    determinant = ground_first * ground_second + total_link * (ground_first + ground_second)
    scale = abs(ground_first) + abs(ground_second) + abs(total_link)
    margin = worst * (abs(determinant) / scale) / scale if scale > 0.0 else 0.0
    if determinant < 0.0:
        count += 1
    elif ground_first + ground_second + 2.0 * total_link < 0.0:
        count += 2
    return count, margin
