"""What `check` answers: the data sheet, warnings, and the margins along a planned motion."""

from dataclasses import replace

from cabledrive.answers.keys import Keys
from cabledrive.app.resonances import indented
from cabledrive.app.results import Answer, provenance
from cabledrive.mechanics.network.span_table import PULLEY_ROW, SPAN_ROW
from cabledrive.modal.lowest import DERIVED, LOWEST
from cabledrive.parameters import Machine, content_hash
from cabledrive.parameters.route.two_pulleys import as_machine, two_pulleys_of
from cabledrive.report.blocks import table_text
from cabledrive.report.machine.data import data_sheet, derived_table, machine_warnings
from cabledrive.report.machine.tables import ALONG, margins_data, margins_tables
from cabledrive.studies.motion_margins import motion_margins
from cabledrive.studies.planned_motion import read_motion

VALID = Keys("flag: valid text: drive_hash texts: warnings object: motion?", parts={"motion": ALONG})
SHEET = Keys(
    "number: cable_length lowest_tension highest_tension count: rigid_body_modes map: spring_preload "
    "reasons=text",
    also=(LOWEST,),
)
ROWS = Keys("rows: spans pulleys", parts={"spans": SPAN_ROW, "pulleys": PULLEY_ROW}, also=(VALID,))
LOOP = Keys("object: derived", parts={"derived": Keys("", also=(DERIVED, SHEET))}, also=(ROWS,))
ROUTE = Keys("object: derived", parts={"derived": SHEET}, also=(ROWS,))
METHOD = "balance of forces, closed formulas; lowest frequencies by the exact dynamic stiffness"


def checked(drive: Machine) -> Answer:
    """Derived quantities, spans and pulleys at rest, and warnings."""
    sheet, warnings = data_sheet(drive), machine_warnings(drive)
    parts = [table_text(one) for one in (derived_table(sheet.derived), *sheet.tables)]
    springs = [
        f"Spring of {name} at rest: {force:.4g} {'N m' if name.endswith('.turn') else 'N'}."
        for name, force in sheet.derived["spring_preload"].items()
    ]
    lines = [f"Warning: {line}." for line in warnings] or ["No warnings."]
    parts.append("\n".join([*springs, *lines]))
    found = {
        "valid": True,
        "drive_hash": content_hash(drive),
        "derived": sheet.derived,
        "spans": [SPAN_ROW(row) for row in sheet.spans],
        "pulleys": [PULLEY_ROW(row) for row in sheet.pulleys],
        "warnings": warnings,
    }
    head = f"{drive.title or drive.name}\nvalid; content hash {content_hash(drive)}"
    return Answer(data=found, text="\n\n".join([head, *parts]), provenance=provenance(drive, method=METHOD))


def with_margins(answer: Answer, drive: Machine, file: str) -> Answer:
    """The same answer with the margins along a planned motion."""
    motion = read_motion(file, drive, torque=False)
    pushed = motion.load_torque is not None
    machine = as_machine(two_pulleys_of(drive, "load_torque"), loaded=True) if pushed else drive
    along = motion.by_pulley(machine.sense)
    found = motion_margins(machine, along)
    parts = [answer.text, "\n".join([f"Planned motion: {found.verdict}", *indented(found.reasons)])]
    parts += [table_text(one) for one in margins_tables(found)]
    parts.append("\n".join(f"Assumes: {words}." for words in found.assumptions))
    return replace(answer, data={**answer.data, "motion": margins_data(found)}, text="\n\n".join(parts))
