"""The page of a comparison of controllers: which law, at what price, on which plants."""

from typing import Any

from cabledrive.answers.figures import number, percent
from cabledrive.answers.runs import COSTS, ERRORS
from cabledrive.parameters import Drive, content_hash
from cabledrive.report.blocks import Block, Chapter, Note, Paragraph, Table, listed, table
from cabledrive.report.page import page_of
from cabledrive.studies.controller_comparison import Comparison

METHOD = "one tuning procedure for all laws, then the same drawn plants, with encoders, filter and delay"


def comparison_html(drive: Drive, found: Comparison) -> str:
    """The page of a comparison; HTML that needs no other file."""
    said = found.summary
    chapter = Chapter(
        "Controllers",
        "controllers",
        (*_notes(said), errors_table(said), costs_table(said), _plants(said)),
        headline=_headline(said),
        methods=(METHOD,),
    )
    title = f"{drive.name}: {said['best'] or 'no law'}"
    hashes = ((drive.name, content_hash(drive)),)
    return page_of(title, "Controllers compared", (chapter,), hashes)


def _headline(said: dict[str, Any]) -> str:
    if said["best"] is None:
        return "No law could be tuned within the limits."
    best, what = said["controllers"][0], said["controllers"][0]["reason"]
    if best["worst_deg"] is not None:
        what = f"worst error {number(best['worst_deg'], 3)} deg over {best['runs']} plants"
    inside = f"{percent(best['share_within'])} within {number(said['goal_deg'], 3)} deg"
    return f"{best['name']} ranks first: {what}, {inside}."


def _notes(said: dict[str, Any]) -> list[Block]:
    limits = said["limits"]
    return [
        Paragraph(
            text=(
                "Every law is tuned by the same procedure: the highest bandwidth with a disk margin of at "
                f"least {limits['disk_margin']:g} and a torque ripple by rounding (five deviations) of at "
                f"most {number(limits['torque_ripple'], 3)} N m, with the filter that has the smallest worst "
                "error on plants set apart for tuning. All laws then run on the same plants. Order: share of "
                "plants within the goal, then worst error; of laws that learn, the error after the first "
                "pulse counts."
            )
        ),
        Note(text="Not covered: " + "; ".join(said["not_covered"]) + "."),
    ]


def errors_table(said: dict[str, Any]) -> Table:
    """Errors of the load over the plants, the best law first."""
    laws = [one | {"reason": _ended(one)} for one in said["controllers"]]
    return listed(f"Error of the load over {said['draws']} plants", ERRORS, laws)


def _ended(one: dict[str, Any]) -> str:
    if not one["runs"]:
        return str(one["reason"])
    return f"{one['failed']} of {one['runs']} ended early" if one["failed"] else ""


def costs_table(said: dict[str, Any]) -> Table:
    """Torque, margins and time to tune of each law."""
    caption = "What each law costs: torque, margins at the motor's torque, time to tune"
    tuned = (one for one in said["controllers"] if one["bandwidth_hz"] is not None)
    return listed(caption, (ERRORS[0], *COSTS), tuned)


def _plants(said: dict[str, Any]) -> Table:
    rows = (
        (name.replace("_", " "), number(low, 3), number(high, 3))
        for name, (low, high) in said["disturbances"].items()
        if (low, high) != (0.0, 0.0)
    )
    caption = "Ranges from which each plant draws, SI, beside the drive's own intervals"
    return table(caption, "quantity | from [] | to []", rows)
