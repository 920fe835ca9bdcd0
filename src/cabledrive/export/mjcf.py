"""Models 1 to 4 of a drive for MuJoCo: a hinge for each inertia, a fixed tendon for each link."""

from xml.etree import ElementTree as Tree

from cabledrive.export.drive_source import lumped_models
from cabledrive.parameters import Drive, content_hash
from cabledrive.parameters.version import __version__
from cabledrive.reduction.lumped_chain import LumpedChain

STEP = 1e-4
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
    Tree.SubElement(root, "option", timestep=f"{STEP}", gravity="0 0 0", integrator="implicitfast")
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
    for j in range(len(chain.ratios)):
        name = f"{chain.names[j]}_{chain.names[j + 1]}"
        k, d = chain.stiffness[j], chain.damping[j]
        last = j == len(chain.ratios) - 1 and chain.names[j + 1] == "load"
        if not last or drive.cable.pretension <= 0.0:
            _tendon(tendons, chain, j, name, (k, d, "0"), 1.0)
            continue
        # The spans pull against each other; each is slack where its stretch has gone back by that at rest.
        spans, signs = len(drive.spans), (1.0, -1.0)
        rest = spans * drive.cable.pretension * drive.drive_pulley.radius / chain.ratios[j][0] / k
        for span in range(spans):
            each = (k / spans, d / spans, f"{NO_PUSH} {-rest!r}")
            _tendon(tendons, chain, j, f"{name}_span_{span}", each, signs[span])


def _tendon(
    tendons: Tree.Element,
    chain: LumpedChain,
    j: int,
    name: str,
    spring: tuple[float, float, str],
    sign: float,
) -> None:
    """A tendon along link j; ``spring``: stiffness, damping, range of lengths without a force."""
    stiffness, damping, length = spring
    settings = {"stiffness": repr(stiffness), "damping": repr(damping), "springlength": length}
    one = Tree.SubElement(tendons, "fixed", {"name": name} | settings)
    p, q = chain.ratios[j]
    Tree.SubElement(one, "joint", joint=chain.names[j], coef=repr(sign * p))
    Tree.SubElement(one, "joint", joint=chain.names[j + 1], coef=repr(-sign * q))
