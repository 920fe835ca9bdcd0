"""An FMU for co-simulation, FMI 2.0 or 3.0: sources, description, a binary where a compiler is at hand."""

import hashlib
import io
import platform
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cabledrive.export.c99 import controller_code
from cabledrive.export.cable_package import (
    Variable,
    cable_code,
    cable_notes,
    cable_variables,
    given,
    output,
    parameter,
)
from cabledrive.export.source import NOTE, ExportSource, plant_loop
from cabledrive.export.system_package import system_code
from cabledrive.export.target_program import target_program, templates
from cabledrive.export.translation.nodes import Precision
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.route.drive import RoutedDrive
from cabledrive.parameters.version import __version__
from cabledrive.reduction.modal_cable import ModalCable, modal_cable

FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden", "-I.")
MADE = (2000, 1, 1, 0, 0, 0)
"""Date of every file of the archive: the same source gives the same archive."""
NO_COMPILER = (
    "no C compiler (cc) is at hand: the FMU has its sources and no binary; compile it with "
    "`python -m fmpy compile`"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """What an FMU holds: ``what``, its sources, variables, title, sample time [s], words for its shell."""

    what: str
    code: Mapping[str, str]
    variables: list[Variable]
    title: str
    interval: float
    words: Mapping[str, Any]
    notes: list[str]


def fmu_package(source: ExportSource, version: int, what: str) -> tuple[dict[str, bytes], list[str]]:
    """The FMU 2 or 3 of "controller", "plant" or "loop" by its name, and notes."""
    if what == "controller":
        code = controller_code(source, target_program(source.law))
    else:
        code = system_code(source, what)
    named = source.drive.name if source.drive is not None else "drive"
    part = Part(
        what=what,
        code=code,
        variables=variables_of(source, what),
        title=f"{named}: {what}" + ("" if what == "plant" else f", law {source.law.name}"),
        interval=source.law.sample_time,
        words={
            "shafts": () if what == "controller" else plant_loop(source).chain.names,
            "encoders": source.law.encoders,
        },
        notes=list(source.notes) + ([NOTE] if what != "controller" else []),
    )
    return packed(part, version)


def cable_fmu(drive: Drive | RoutedDrive, version: int) -> tuple[dict[str, bytes], list[str], ModalCable]:
    """The FMU of the cable of a drive by its name, notes, and the cable in modes."""
    cable = modal_cable(drive)
    variables = cable_variables(cable)
    names = [variable.name for variable in variables]
    first = len(cable.inputs) + (len(cable.spans) if cable.sine else 0)
    tensions = first + 2 * len(cable.motions)
    places = {
        "plucks": len(cable.inputs),
        "motions": first,
        "speeds": first + len(cable.motions),
        "tensions": tensions,
        "middles": tensions + len(cable.spans) if cable.sine else 0,
    }
    if len(set(names)) != len(names):
        raise InputRefused("two parts of the machine have names that are one in C: rename one")
    part = Part(
        what="cable",
        code=cable_code(drive, cable),
        variables=variables,
        title=f"{drive.name}: cable in modes",
        interval=cable.interval,
        words={"places": places},
        notes=cable_notes(cable),
    )
    return (*packed(part, version), cable)


def packed(part: Part, version: int) -> tuple[dict[str, bytes], list[str]]:
    """The FMU of a part by its name, and notes."""
    what, name = part.what, f"cabledrive_{part.what}"
    sources = dict(part.code) | _shell(part, version)
    files: dict[str, bytes] = {f"sources/{each}": text.encode() for each, text in sources.items()}
    files["modelDescription.xml"] = _description(part, version).encode()
    if version == 3:
        build = templates().get_template("buildDescription.xml.jinja")
        files["sources/buildDescription.xml"] = build.render(name=name, compiled=_compiled(what)).encode()
    notes = list(part.notes)
    binary = compiled_library(sources, _compiled(what), name)
    if binary is None:
        notes.append(NO_COMPILER)
    else:
        files[f"binaries/{binary_folder(version)}/{name}{_suffix()}"] = binary
    return {f"{name}.fmu": archive(files)}, notes


def variables_of(source: ExportSource, what: str) -> list[Variable]:
    """Inputs, parameters and outputs, in the order of their reference numbers."""
    law = source.law
    readings = [f"{name}_encoder" for name in law.encoders]
    disturbances = [given(f"{on}_torque", "N.m", f"disturbance on the {on}") for on in ("motor", "load")]
    command = output("command", "N.m", "limited command")
    kept = output("kept", "", "1 where the last command was kept")
    if what == "controller":
        rows = [given(f"ref_{i}", "", column) for i, column in enumerate(law.columns)]
        return [*(given(one, "rad", "angle read") for one in readings), *rows, command, kept]
    outputs = [output(one, "rad", "angle read") for one in readings]
    shafts = plant_loop(source).chain.names
    for unit, kind in (("rad", "angle"), ("rad/s", "speed")):
        outputs += [output(f"{one}_{kind}", unit, f"true {kind} of the {one}") for one in shafts]
    outputs.append(output("slip", "", "1, -1: the motor slips; 0: sticks"))
    if what == "plant":
        return [given("command", "N.m", "torque asked of the motor"), *disturbances, *outputs]
    motion = [
        parameter("angle", "rad", "of the load, there and back", 0.5),
        parameter("rise", "s", "time of a move", 0.5),
        parameter("dwell", "s", "rest after a move", 0.5),
        parameter("pulses", "", "how many", 1.0),
    ]
    wanted = output("wanted", "rad", "wanted load angle of the last sample")
    return [*motion, *disturbances, command, kept, wanted, *outputs]


def token_of(code: Mapping[str, str]) -> str:
    """Identity of an FMU, by its translated sources."""
    digest = hashlib.sha256("".join(code[name] for name in sorted(code)).encode()).hexdigest()
    return f"{{{digest[:8]}-{digest[8:12]}-{digest[12:16]}-{digest[16:20]}-{digest[20:32]}}}"


def _compiled(what: str) -> list[str]:
    return ["fmu.c", "cabledrive_law.c" if what == "controller" else f"cabledrive_{what}.c"]


def _shell(part: Part, version: int) -> dict[str, str]:
    shell = templates().get_template("fmu_part.c.jinja")
    words: dict[str, Any] = {"what": part.what, "variables": part.variables, "token": token_of(part.code)}
    return {
        "part.c": shell.render(**words, **part.words, literal=Precision().literal),
        "fmu.c": templates().get_template(f"fmi{version}.c.jinja").render(),
    }


def _description(part: Part, version: int) -> str:
    return (
        templates()
        .get_template(f"fmi{version}.xml.jinja")
        .render(
            name=f"cabledrive_{part.what}",
            title=part.title,
            token=token_of(part.code),
            version=__version__,
            compiled=_compiled(part.what),
            units=sorted({variable.unit for variable in part.variables if variable.unit}),
            variables=part.variables,
            step=repr(part.interval),
            stop=repr(1000 * part.interval),
        )
    )


def compiled_library(sources: Mapping[str, str], compiled: list[str], name: str) -> bytes | None:
    """The shared library of an FMU; none where no compiler is at hand."""
    compiler = shutil.which("cc")
    if compiler is None or platform.system() == "Windows":
        return None
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        for each, text in sources.items():
            (place / each).write_text(text, encoding="utf-8")
        command = [compiler, *FLAGS, *compiled, "-lm", "-o", name + _suffix()]
        subprocess.run(command, cwd=place, check=True, capture_output=True)
        return (place / (name + _suffix())).read_bytes()


def _suffix() -> str:
    return ".dylib" if platform.system() == "Darwin" else ".so"


def binary_folder(version: int) -> str:
    """Folder of this platform's binary in an FMU."""
    system, machine = platform.system(), platform.machine().lower()
    if version == 2:
        return "darwin64" if system == "Darwin" else "linux64"
    cpu = {"amd64": "x86_64", "arm64": "aarch64"}.get(machine, machine)
    return f"{cpu}-{'darwin' if system == 'Darwin' else 'linux'}"


def archive(files: Mapping[str, bytes]) -> bytes:
    """A ZIP archive, the same for the same files."""
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as made:
        for name in sorted(files):
            made.writestr(zipfile.ZipInfo(name, MADE), files[name], zipfile.ZIP_DEFLATED)
    return target.getvalue()
