"""The loop under the planned torque, as a figure that moves."""

from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.route.two_pulleys import AxisDrive
from cabledrive.reduction.quality import with_measured_stiffness
from cabledrive.report.animation import animation_svg
from cabledrive.report.blocks import Block, Figure, Paragraph
from cabledrive.report.wording import texts
from cabledrive.simulation import Recording, Scheme, simulate
from cabledrive.simulation.run import whole
from cabledrive.simulation.signals import Sampled
from cabledrive.studies.study import StudyResult
from cabledrive.studies.study.resonance_stage import motion_torque

say = texts("study_loop")
SEGMENTS, FRAMES, RATE = 12, 60, 2000.0
MOST_STEPS = 2e6


def loop_in_motion(result: StudyResult) -> Block:
    """The nonlinear loop under the torque of the motion, without feedback; or the reason why not."""
    if isinstance(result.known, AxisDrive):
        return Paragraph(text=say("axis", load=result.known.load))
    machine, motion = with_measured_stiffness(result.known), result.goals.motion
    duration = motion.trajectory.duration
    waves = (machine.cable.axial_rigidity / machine.cable.mass_per_length) ** 0.5 / machine.span_length
    if duration * waves * SEGMENTS > MOST_STEPS:
        return Paragraph(text=say("too_stiff"))
    time, torque = motion_torque(machine, motion)
    try:
        run = whole(
            simulate(
                machine,
                duration,
                torque=Sampled(values=torque, rate=(len(time) - 1) / duration),
                scheme=Scheme(slack="tension-only", segments=SEGMENTS),
                recording=Recording(rate=RATE, fields=max(1, round(RATE * duration / FRAMES))),
            )
        )
        switch, wide, narrow = animation_svg("loop-in-motion", machine, run)
    except (InputRefused, NotComputed) as failure:
        return Paragraph(text=say("refused", failure=failure))
    return Figure(
        name="loop-in-motion",
        alt=say("seen"),
        caption=say("caption"),
        switch=switch,
        wide=wide,
        narrow=narrow,
    )
