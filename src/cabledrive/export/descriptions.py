"""A machine as others describe it: for MuJoCo, in Modelica, in the lines of printer firmware."""

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Tree

from cabledrive.export.blocks import TEMPLATES
from cabledrive.export.source import lumped_models
from cabledrive.parameters import Drive, InputRefused, content_hash
from cabledrive.parameters.files import require_regular
from cabledrive.parameters.version import __version__
from cabledrive.reduction.lumped_chain import LumpedChain, natural_frequencies_of

STEP, RADIANS = 1e-4, 0.25
"""Largest step for MuJoCo [s], and turn of the fastest mode in one, which diverges from 2 on."""
NO_PUSH = -1e6  # length below which a tendon would push: never reached
LINES = (
    "Angles are those of each shaft [rad], torques in N m. A tendon is a link: its stretch is r1 q1 - r2 q2.",
    "The cable is a tendon for each span, which pulls and never pushes: slack, it carries nothing.",
)


def mjcf_files(drive: Drive) -> dict[str, str]:
    """One file for each of the Models 1 to 4 that the drive's data allow."""
    return {f"model-{n}.xml": mjcf(drive, chain, f"model-{n}") for n, chain in lumped_models(drive).items()}


def mjcf(drive: Drive, chain: LumpedChain, name: str) -> str:
    """A lumped chain in MuJoCo's own format."""
    root = Tree.Element("mujoco", model=f"{drive.name} {name}")
    root.append(Tree.Comment(f" cabledrive {__version__}, drive {content_hash(drive)} "))
    for line in LINES:
        root.append(Tree.Comment(f" {line} "))
    fastest = float(natural_frequencies_of(chain).max(initial=RADIANS / STEP))
    step = {"timestep": f"{RADIANS / fastest:.4g}"}
    Tree.SubElement(root, "option", step | {"gravity": "0 0 0", "integrator": "implicitfast"})
    world = Tree.SubElement(root, "worldbody")
    for i, shaft in enumerate(chain.names):
        body = Tree.SubElement(world, "body", name=shaft, pos=f"0 0 {0.2 * i:g}")
        joint = {"name": shaft, "type": "hinge", "axis": "0 0 1", "damping": repr(chain.viscous[i])}
        joint["frictionloss"] = repr(chain.coulomb[i])
        if i == 0 and chain.holding > 0.0:
            joint["stiffness"] = repr(chain.holding)
        Tree.SubElement(body, "joint", joint)
        inertia = repr(chain.inertias[i])
        # Mass and the other moments do not move: any will do.
        Tree.SubElement(body, "inertial", pos="0 0 0", mass="1", diaginertia=f"{inertia} {inertia} {inertia}")
    _links(root, drive, chain)
    actuator = Tree.SubElement(root, "actuator")
    bias = {"biastype": "affine", "biasprm": f"{chain.offsets[0]!r} 0 0"}  # the motor's offset torque
    Tree.SubElement(actuator, "general", {"name": "torque", "joint": chain.names[0]} | bias)
    sensor = Tree.SubElement(root, "sensor")
    for shaft in chain.names:
        Tree.SubElement(sensor, "jointpos", name=f"{shaft}_angle", joint=shaft)
        Tree.SubElement(sensor, "jointvel", name=f"{shaft}_speed", joint=shaft)
    Tree.indent(root)
    return Tree.tostring(root, encoding="unicode") + "\n"


def _links(root: Tree.Element, drive: Drive, chain: LumpedChain) -> None:
    if not chain.stiffness:
        return
    tendons = Tree.SubElement(root, "tendon")
    for j, (p, q) in enumerate(chain.ratios):
        first, second = chain.names[j : j + 2]
        k, d, idle, signs = chain.stiffness[j], chain.damping[j], "0", {"": 1.0}
        if j == len(chain.ratios) - 1 and second == "load" and drive.cable.pretension > 0.0:
            # The spans pull against each other; each is slack once its stretch has gone back by that at rest.
            spans = len(drive.spans)
            rest = spans * drive.cable.pretension * drive.drive_pulley.radius / p / k
            k, d, idle = k / spans, d / spans, f"{NO_PUSH} {-rest!r}"
            signs = {f"_span_{i}": (1.0, -1.0)[i] for i in range(spans)}
        for span, sign in signs.items():
            settings = {"stiffness": repr(k), "damping": repr(d), "springlength": idle}
            one = Tree.SubElement(tendons, "fixed", {"name": f"{first}_{second}{span}"} | settings)
            Tree.SubElement(one, "joint", joint=first, coef=repr(sign * p))
            Tree.SubElement(one, "joint", joint=second, coef=repr(-sign * q))


def modelica_files(drive: Drive) -> dict[str, str]:
    """One model for each of the Models 1 to 4 that the drive's data allow."""
    template = TEMPLATES.get_template("model.mo.jinja")
    return {
        f"Model{n}.mo": template.render(
            number=n, drive=drive, chain=chain, version=__version__, hash=content_hash(drive), repr=repr
        )
        for n, chain in lumped_models(drive).items()
    }


REMEDY = "give the JSON of `cabledrive shaper LOG --json -o FILE`"


def klipper_files(source: Any) -> dict[str, str]:
    """The configuration of Klipper, and the same for Marlin; refused if it is no answer of `shaper`."""
    place = require_regular(Path(str(source)), REMEDY)
    try:
        data = json.loads(place.read_text(encoding="utf-8"))
        parts = [_firmware(one, str(place)) for one in data.get("axes", [data])]
    except InputRefused:
        raise
    except OSError as error:
        raise InputRefused(f"cannot be read ({error.strerror}): {REMEDY}").at(str(place)) from None
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputRefused(f"is no answer of shaper ({type(error).__name__}: {error}): {REMEDY}").at(
            str(place)
        ) from None
    if not parts:
        raise InputRefused("holds no axis: give the logs of an axis as well").at(str(place))
    lines = ["[input_shaper]", *(own.partition("\n")[2] for own, _ in parts)]
    return {"printer.cfg": "\n".join(lines) + "\n", "marlin.gcode": "".join(own for _, own in parts)}


def _firmware(data: dict[str, Any], place: str) -> tuple[str, str]:
    """The lines of one axis for Klipper and for Marlin."""
    if data["recommended"] is None:
        raise InputRefused(f"recommends no shaper: {data['recommended_reason']}").at(place)
    axis, type_ = data["axis"], str(data["recommended"])
    hertz, damping = float(data["recommended_shaper"]["frequency_hz"]), float(data["damping"])
    if not isinstance(axis, str):
        raise InputRefused("names no axis: run shaper again with --axis x, y or z").at(place)
    note = "" if type_.upper() == "ZV" else f" ; Marlin has ZV alone: the type {type_} was recommended"
    return str(data["configuration"]), f"M593 {axis.upper()} F{hertz:.1f} D{damping:.3g}{note}\n"
