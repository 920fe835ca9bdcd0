"""`cabledrive sway`: ropes of a lift in a building that sways."""

from cabledrive.app.options import machine_argument, opt, saves_answer, subcommand
from cabledrive.app.results import Answer, provenance
from cabledrive.parameters import Machine

METHOD = "strings under their weight, ends moving with the building"
NOTE = "Steady state across the plane of the machine; ropes touch nothing, the building's shape is straight"


@subcommand(
    "cabledrive sway lift-2-to-1 --building 0.2Hz --amplitude 50mm --vary car.y=2m:38m",
    (saves_answer, machine_argument),
)
def command(
    drive: Machine,
    building: float = opt("Hz", "Frequency at which the building sways.", required=True),
    amplitude: float = opt(
        "m", "Its horizontal amplitude at the highest part of the machine.", required=True
    ),
    text: str | None = opt(
        "KEY=FROM:TO[:N]",
        "Places of a body, such as car.y=2m:38m; default: the pose of the file.",
        flags="--vary",
    ),
) -> Answer:
    """First frequency and amplitude of every rope of DRIVE in a building that sways, over places."""
    from cabledrive.answers.figures import quantity
    from cabledrive.app.maps import SWAY, vary_of
    from cabledrive.report.blocks import table, table_text
    from cabledrive.studies.sway import STEEP, sway

    found = sway(drive, building, amplitude, vary_of(drive, (text,)) if text else None)
    key = found.keys[0] if found.keys else ""
    top, bottom = (quantity(height, "m", 4) for height in (found.top, found.bottom))
    shown = []
    for rope in found.ropes:
        low, high, worst = rope.frequency_hz.min(), rope.frequency_hz.max(), int(rope.amplitude.argmax())
        span = f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"
        at = [f"{found.places[worst]:.4g}"] if key else []
        shown.append((rope.name, span, quantity(rope.amplitude[worst], "m", 3), *at))
    heads = "rope | first mode [Hz] | largest amplitude []" + (f" | at {key} [m]" if key else "")
    beyond = [rope for rope in found.ropes if rope.largest_share > STEEP]
    warnings = [
        f"{rope.name}: {100 * rope.largest_share:.2g} % of its length: its stretching, left out, limits it"
        for rope in beyond
    ]
    lines = [
        drive.title or drive.name,
        f"The building sways at {quantity(building, 'Hz')} by {quantity(amplitude, 'm')} at {top}, "
        f"in proportion to the height above {bottom}.",
        "",
        table_text(table("", heads, shown)),
        "",
        *(f"Warning: {line}." for line in warnings),
        f"{NOTE}.",
    ]
    return Answer(
        data=SWAY(found) | {"warnings": warnings, "assumptions": [NOTE]},
        text="\n".join(lines),
        provenance=provenance(drive, method=METHOD),
    )
