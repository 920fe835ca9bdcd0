"""`cabledrive export`: a controller, a plant or a loop for other programs and for firmware."""

from pathlib import Path

from cabledrive.answers.keys import Keys
from cabledrive.app.options import argument, opt, subcommand
from cabledrive.app.results import Answer, provenance
from cabledrive.parameters import InputRefused

KERNELS = "kernels translated to C99; oracle of the self-test: the same kernels, interpreted"
LUMPED = "lumped Models 1 to 4 of the drive, links linear"
METHODS = {"mjcf": LUMPED, "modelica": LUMPED, "klipper": "numbers as `shaper` found them"}

WRITTEN = Keys(
    "text: format texts: files notes number: sample_time note: drive_hash",
    {"sample_time": "the source names no sample rate", "drive_hash": "the source is no drive"},
)


@subcommand("cabledrive export dissertation-3 --format c99 --controller lqg -o firmware")
def command(
    source: str = argument("SOURCE"),
    format_: str = opt(
        "c99|fmu2|fmu3|mjcf|modelica|klipper",
        "c99, fmu2, fmu3, mjcf, modelica or klipper.",
        required=True,
        metavar="FORMAT",
        flags="--format",
    ),
    controller: str | None = opt("NAME", "Control law for a drive; default: by the motor joint."),
    axis: str | None = opt("NAME", "Axis: its load, such as head.x."),
    what: str = opt("controller|plant|loop|cable", "Which part is written.", "controller"),
    float32: bool = opt("flag", "Single precision; refused where the law does not hold in it."),
    anyway: bool = opt("flag", "Also the law of a study without yes; the reason stands in the files."),
    output: str = opt("path", "New folder to write.", required=True, metavar="DIR", flags="-o --output"),
) -> Answer:
    """Write the controller, plant or loop of SOURCE as C99, an FMU or another program's model.

    SOURCE is a study's folder, a controller.json, a drive (name or file), or the JSON of `shaper`.
    """
    from cabledrive.export import export_to

    if not source:
        raise InputRefused("SOURCE names nothing: give a study's folder, a controller.json or a drive")
    found = export_to(
        output, source, format_, controller=controller, axis=axis, what=what, float32=float32, anyway=anyway
    )
    lines = [f"{format_}: {len(found['files'])} files in {Path(output)}", *(f"  {n}" for n in found["files"])]
    if format_ == "c99":
        compile_ = "cc -std=c99 -ffp-contract=off *.c -lm -o check && ./check"
        lines += ["", f"self-test: cd {output} && {compile_}"]
    lines += [f"note: {note}" for note in found["notes"]]
    return Answer(
        data=WRITTEN(found),
        text="\n".join(lines),
        provenance=provenance(method=METHODS.get(format_, KERNELS)),
    )
