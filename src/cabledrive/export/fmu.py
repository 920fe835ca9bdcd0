"""An FMU for co-simulation, FMI 2.0 or 3.0: sources, description, a binary where a compiler is at hand."""

import hashlib
import io
import platform
import shutil
import subprocess
import tempfile
import uuid
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cabledrive.export.blocks import Block

FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden", "-I.")
MADE = (2000, 1, 1, 0, 0, 0)
"""Date of every file of the archive: the same source gives the same archive."""
MAC = platform.system() == "Darwin"
SUFFIX = ".dylib" if MAC else ".so"
PROCESSORS = {"amd64": "x86_64", "arm64": "aarch64"}
NO_COMPILER = (
    "no C compiler (cc) is at hand: the FMU has its sources and no binary; compile it with "
    "`python -m fmpy compile`"
)


def fmu_package(block: Block, version: int) -> tuple[dict[str, bytes], list[str]]:
    """The FMU 2 or 3 of a block by its name, and notes."""
    name, notes, code = f"cabledrive_{block.what}", list(block.notes), block.code()
    digest = hashlib.sha256("".join(code[each] for each in sorted(code)).encode()).hexdigest()
    words: dict[str, Any] = {
        "name": name,
        "token": f"{{{uuid.UUID(digest[:32])}}}",
        "compiled": ["fmu.c", f"{block.file}.c"],
        "variables": block.variables,
    }
    sources = code | {
        "part.c": block.rendered("fmu_part.c.jinja", **words),
        "fmu.c": block.rendered(f"fmi{version}.c.jinja"),
    }
    files: dict[str, bytes] = {f"sources/{each}": text.encode() for each, text in sources.items()}
    law = f", law {block.words['law'].name}" if block.what in ("controller", "loop") else ""
    described = block.rendered(
        f"fmi{version}.xml.jinja",
        **words,
        title=f"{block.drive}: {'cable in modes' if block.what == 'cable' else block.what}{law}",
        units=sorted({variable.unit for variable in block.variables if variable.unit}),
        step=repr(block.interval),
        stop=repr(1000 * block.interval),
    )
    files["modelDescription.xml"] = described.encode()
    if version == 3:
        files["sources/buildDescription.xml"] = block.rendered("buildDescription.xml.jinja", **words).encode()
    binary = compiled_library(sources, words["compiled"], name)
    if binary is None:
        notes.append(NO_COMPILER)
    else:
        files[f"binaries/{binary_folder(version)}/{name}{SUFFIX}"] = binary
    return {f"{name}.fmu": archive(files)}, notes


def compiled_library(sources: Mapping[str, str], compiled: list[str], name: str) -> bytes | None:
    """The shared library of an FMU; none where no compiler is at hand."""
    compiler = shutil.which("cc")
    if compiler is None or platform.system() == "Windows":
        return None
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        for each, text in sources.items():
            (place / each).write_text(text, encoding="utf-8")
        command = [compiler, *FLAGS, *compiled, "-lm", "-o", name + SUFFIX]
        subprocess.run(command, cwd=place, check=True, capture_output=True)
        return (place / (name + SUFFIX)).read_bytes()


def binary_folder(version: int) -> str:
    """Folder of this platform's binary in an FMU."""
    if version == 2:
        return "darwin64" if MAC else "linux64"
    machine = platform.machine().lower()
    return f"{PROCESSORS.get(machine, machine)}-{'darwin' if MAC else 'linux'}"


def archive(files: Mapping[str, bytes]) -> bytes:
    """A ZIP archive, the same for the same files."""
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as made:
        for name in sorted(files):
            made.writestr(zipfile.ZipInfo(name, MADE), files[name], zipfile.ZIP_DEFLATED)
    return target.getvalue()
