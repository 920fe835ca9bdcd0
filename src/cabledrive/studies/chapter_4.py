"""The experiments of chapter 4 on the virtual rig: five bench tests, two responses, the amplifier."""

from dataclasses import dataclass, replace

import numpy as np

from cabledrive.identification.axis.against import RegressorCurves, regressor_curves
from cabledrive.identification.axis.axis import AxisOptions, identify_rigid_axis
from cabledrive.identification.axis.equation import FrictionModel
from cabledrive.identification.axis.simulated import refine_rigid_axis
from cabledrive.identification.estimates import Estimate, Identification
from cabledrive.identification.frequency_response import FrequencyResponse, response_by_segments
from cabledrive.identification.log_response import compensated_torque, speed_of
from cabledrive.identification.logs.log import Log
from cabledrive.identification.response_models import (
    AmplifierFit,
    ResponseFit,
    fit_response,
    identify_amplifier,
)
from cabledrive.identification.wrap_friction import inertias_of_the_rigs
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.bench.virtual_rig import (
    BENCH_TESTS,
    TORQUE_PER_VOLT,
    BenchTest,
    VirtualRig,
    bench_command,
    bench_rig,
    response_command,
    run_rig,
)

SEED = 2015
RATE = 5000.0
"""Of the responses [Hz], section 4.3."""
SETTLED = 3.0
"""The first seconds of a response are left out, section 4.3: the last five of eight are used."""
JOINT = (135.0, 0.075)
"""Stiffness and damping of the coupling that the print matched by hand [N m/rad, N m s/rad]."""
MOTOR, WITH_DRIVE, WITH_LOAD = BENCH_TESTS


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Experiment:
    """One bench test on the virtual rig."""

    title: str
    figures: str  # the printed figures that it stands beside
    shown: float  # how much of it those show [s]
    test: BenchTest
    # found, printed_regressor: with the sign of the speed, refined by output error; by inverse dynamics with
    # tanh(0.5 w)
    found: Identification
    printed_regressor: Identification
    curves: RegressorCurves  # with tanh(0.5 w), as printed
    error_share: float  # modelling error over torque with the sign of the speed


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ResponseExperiment:
    """A response from torque to motor speed."""

    measured: FrequencyResponse
    chain: LumpedChain  # what made it
    fit: ResponseFit


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Chapter4:
    """Everything that chapter 4 shows."""

    experiments: tuple[Experiment, ...]
    inertias: dict[str, Estimate]  # as in Table 4.2
    # motor, coupled: the motor alone, and with the drive pulley on its coupling
    motor: ResponseExperiment
    coupled: ResponseExperiment
    amplifier: AmplifierFit
    amplifier_response: FrequencyResponse


def chapter_4(seed: int = SEED) -> Chapter4:
    """Run and identify the experiments of chapter 4; ``seed``: of phases, noise and encoder phases."""
    two = replace(WITH_DRIVE, amplitudes=(0.1, 0.1))
    plan = (
        ("Motor and drive pulley, 3 and 4 Hz", "4.7 and 4.8", 1.0, replace(two, frequencies=(3.0, 4.0))),
        ("Motor and drive pulley, 1 and 5 Hz", "4.9 and 4.10", 2.0, replace(two, frequencies=(1.0, 5.0))),
        ("Motor and drive pulley, 1, 3 and 5 Hz", "4.11 and 4.12", 2.0, WITH_DRIVE),
        ("Motor alone", "4.13 and 4.14", 2.0, MOTOR),
        ("Motor and load pulley", "4.15 and 4.16", 2.0, WITH_LOAD),
    )
    streams = np.random.default_rng(seed).spawn(len(plan) + 2)
    experiments = tuple(_experiment(*row, rng) for row, rng in zip(plan, streams, strict=False))
    rigs = [experiments[k].found for k in (3, 2, 4)]
    motor_log, motor_chain = _response_log(None, streams[-2])
    coupled_log, coupled_chain = _response_log(JOINT, streams[-1])
    last = motor_log.part(start=SETTLED)
    return Chapter4(
        experiments=experiments,
        inertias=inertias_of_the_rigs(*rigs),
        motor=_response(motor_log, motor_chain, 1),
        coupled=_response(coupled_log, coupled_chain, 2),
        amplifier=identify_amplifier(last),
        amplifier_response=response_by_segments(
            last.channel("command_voltage"), last.channel("torque"), last.interval
        ),
    )


def _experiment(
    title: str, figures: str, shown: float, test: BenchTest, rng: np.random.Generator
) -> Experiment:
    log = run_rig(bench_rig(test), bench_command(test, rng), rng, source=title)
    smooth = AxisOptions(friction=FrictionModel(kind="tanh"))
    found = refine_rigid_axis([log], identify_rigid_axis([log]))
    printed = identify_rigid_axis([log], smooth)
    return Experiment(
        title=title,
        figures=figures,
        shown=shown,
        test=test,
        found=found,
        printed_regressor=printed,
        curves=regressor_curves(log, printed),
        error_share=regressor_curves(log, found).error_share,
    )


def _response_log(joint: tuple[float, float] | None, rng: np.random.Generator) -> tuple[Log, LumpedChain]:
    """Eight seconds of 1,000 sines on the motor, alone or with the drive pulley on its coupling."""
    pulley = joint is not None
    test = WITH_DRIVE if pulley else MOTOR
    shafts = 2 if pulley else 1
    chain = LumpedChain(
        names=("motor", "drive")[:shafts],
        inertias=(MOTOR.inertia, WITH_DRIVE.inertia - MOTOR.inertia)[:shafts],
        viscous=(test.viscous, 0.0)[:shafts],
        coulomb=(test.coulomb, 0.0)[:shafts],
        offsets=(test.offset, 0.0)[:shafts],
        stiffness=(joint[0],) if joint else (),
        damping=(joint[1],) if joint else (),
        ratios=((1.0, 1.0),) if joint else (),
    )
    rig = VirtualRig(chain=chain, torque_per_volt=TORQUE_PER_VOLT, sample_rate=RATE)
    return run_rig(rig, response_command(rng, sample_rate=RATE), rng), chain


def _response(log: Log, chain: LumpedChain, model: int) -> ResponseExperiment:
    """Friction and offset taken off, then windows of 1 s with 0.2 s of overlap over the last five seconds."""
    last = log.part(start=SETTLED)
    speed = speed_of(last, "angle")
    torque = compensated_torque(last.channel("torque"), speed, chain.coulomb[0], chain.offsets[0])
    measured = response_by_segments(torque, speed, last.interval)
    start = {"inertia": sum(chain.inertias), "viscous_friction": chain.viscous[0]}
    if model == 2:
        start = {
            "motor_inertia": chain.inertias[0],
            "load_inertia": chain.inertias[1],
            "viscous_friction": chain.viscous[0],
            "joint_stiffness": 100.0,
            "joint_damping": 0.05,
        }
    inertias = {name: value for name, value in start.items() if model == 2 and name.endswith("inertia")}
    fit = fit_response(measured.between(5.0, 300.0).independent(), model, start, fixed=inertias)
    return ResponseExperiment(measured=measured, chain=chain, fit=fit)
