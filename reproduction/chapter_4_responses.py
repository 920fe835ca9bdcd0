"""Figs. 4.17 and 4.19: frequency responses of the motor, alone and with the drive pulley."""

from math import pi, sqrt

from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.bench.virtual_rig import BENCH_TESTS, bench_rig
from reproduction.item import DIFFERS, ERRATUM, Entry, Outcome, outcome, place
from reproduction.judge import claimed, compared
from reproduction.responses import measured_response

JOINT, JOINT_DAMPING = 135.0, 0.075
MOTOR = BENCH_TESTS[0].inertia
PULLEY = BENCH_TESTS[1].inertia - MOTOR
CLOSE = 0.25
"""Median difference that an eye calls a good agreement on logarithmic axes: 2 dB."""

FRICTION = (
    DIFFERS,
    "friction that sticks does not go away with a constant: at low speeds the compensated torque is not what "
    "moves",
)


def motor_alone() -> LumpedChain:
    """The motor of Table 4.1."""
    return bench_rig(BENCH_TESTS[0]).chain


def motor_with_pulley() -> LumpedChain:
    """Motor and drive pulley with the joint of section 4.3.2."""
    both = BENCH_TESTS[1]
    return LumpedChain(
        names=("motor", "drive"),
        inertias=(MOTOR, PULLEY),
        viscous=(both.viscous, 0.0),
        coulomb=(both.coulomb, 0.0),
        offsets=(both.offset, 0.0),
        stiffness=(JOINT,),
        damping=(JOINT_DAMPING,),
        ratios=((1.0, 1.0),),
    )


def figure_4_17(quick: bool) -> Outcome:
    """Fig. 4.17: the motor alone.

    ``quick``: changes nothing here.
    """
    found = measured_response(motor_alone())
    off = found.off
    item = claimed(
        "figure-4-17",
        "Fig. 4.17: response of the motor, measured and by (4.17)",
        "a good agreement is seen",
        f"median difference {100 * off:.2g} % from 5 to 100 Hz, virtual rig",
        off < CLOSE,
        otherwise=FRICTION,
        note=(
            "windows of 2.5 s, since 1 s does not part the lines; above 100 Hz the encoder's counts drown "
            "the speed. "
            f"{place('erratum-4-14-line-spacing')}"
        ),
    )
    return outcome([item], [found.panel("Fig. 4.17", "Motor, virtual rig and theory")])


def figure_4_19(quick: bool) -> Outcome:
    """Fig. 4.19: motor and drive pulley, with the joint.

    ``quick``: changes nothing here.
    """
    found = measured_response(motor_with_pulley())
    off = found.off
    anti = sqrt(JOINT / PULLEY) / (2 * pi)
    pair = sqrt(JOINT * (1 / MOTOR + 1 / PULLEY)) / (2 * pi)
    items = [
        claimed(
            "figure-4-19",
            "Fig. 4.19: response of motor and drive pulley, measured and by (4.19)",
            "closely matched",
            f"median difference {100 * off:.2g} % from 5 to 100 Hz, virtual rig",
            off < CLOSE,
            otherwise=FRICTION,
        ),
        compared(
            "section-4-3-2-joint",
            "Section 4.3.2: resonance of the joint, near 100 Hz",
            "100",
            pair,
            "Hz",
            tolerance=10.0,
            note=f"anti-resonance {anti:.1f} Hz; near 100 Hz is generous. {place('number-joint-pair')}",
        ),
        claimed(
            "section-4-3-2-second-line",
            "(4.19), second line: coefficient of s^2",
            "bm (1/J11 + 1/J12)",
            "bm (1/J11 + 1/J12) + b1/J11",
            False,
            otherwise=(ERRATUM, f"the expansion of the first line. {place('erratum-4-19-second-line')}"),
        ),
    ]
    return outcome(items, [found.panel("Fig. 4.19", "Motor and drive pulley, virtual rig and theory")])


ENTRIES = (
    Entry(name="figure-4-17", chapter="4", covers=("Fig. 4.17",), compute=figure_4_17),
    Entry(name="figure-4-19", chapter="4", covers=("Fig. 4.19", "Section 4.3.2"), compute=figure_4_19),
)
