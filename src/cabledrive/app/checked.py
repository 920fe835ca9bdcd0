"""Keys of what `check` answers, and the margins along a planned motion."""

from dataclasses import replace

from cabledrive.answers.keys import Keys
from cabledrive.app.resonances import indented
from cabledrive.app.results import Answer
from cabledrive.mechanics.network.span_table import PULLEY_ROW, SPAN_ROW
from cabledrive.modal.lowest import DERIVED, LOWEST
from cabledrive.parameters.route import Machine, RoutedDrive
from cabledrive.parameters.route.two_pulleys import as_machine
from cabledrive.report.blocks import table_text
from cabledrive.report.machine.tables import ALONG, margins_data, margins_tables
from cabledrive.studies.motion_margins import motion_margins
from cabledrive.studies.planned_motion import read_motion

VALID = Keys("flag: valid text: drive_hash texts: warnings object: motion?", parts={"motion": ALONG})
LOOP = Keys("object: derived", parts={"derived": DERIVED}, also=(VALID,))
OF_ROUTES = Keys(
    "number: cable_length lowest_tension highest_tension count: rigid_body_modes map: spring_preload "
    "reasons=text",
    also=(LOWEST,),
)
ROUTE = Keys(
    "object: derived rows: spans pulleys",
    parts={"derived": OF_ROUTES, "spans": SPAN_ROW, "pulleys": PULLEY_ROW},
    also=(VALID,),
)


def with_margins(answer: Answer, drive: Machine, file: str) -> Answer:
    """The same answer with the margins along a planned motion."""
    if isinstance(drive, RoutedDrive):
        found = motion_margins(drive, read_motion(file, drive, torque=False))
    else:
        motion = read_motion(file)
        machine = as_machine(drive, loaded=motion.load_torque is not None)
        pulleys = zip(machine.pulley, (drive.drive_pulley, drive.load_pulley), strict=True)
        wraps = {named.name: own.wrap_angle for named, own in pulleys if own.wrap_angle is not None}
        found = motion_margins(machine, motion.of_two_pulleys(), wraps=wraps)
    parts = [answer.text, "\n".join([f"Planned motion: {found.verdict}", *indented(found.reasons)])]
    parts += [table_text(one) for one in margins_tables(found)]
    parts.append("\n".join(f"Assumes: {words}." for words in found.assumptions))
    return replace(answer, data={**answer.data, "motion": margins_data(found)}, text="\n\n".join(parts))
