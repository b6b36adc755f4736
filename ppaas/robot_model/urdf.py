"""Parts of a URDF that navigation uses: links with their shapes, and joints. http://wiki.ros.org/urdf/XML"""

from dataclasses import dataclass
from xml.etree.ElementTree import Element

from ppaas.errors import InvalidUrdf
from ppaas.robot_model.shapes import PlacedShape, read_origin, read_shapes
from ppaas.robot_model.xml_document import name_of, number, numbers, required, unit
from ppaas.transforms.spatial import Rigid

JOINT_TYPES = ("fixed", "continuous", "revolute", "prismatic", "floating", "planar")
TURNING = ("continuous", "revolute")

MAX_LINKS = 1000
"""Limit of links and of joints, equal to ``ppaas.messages.tf2_msgs.MAX_FRAMES``."""

MAX_SHAPES = 2000
"""Limit of shapes of all links together."""


@dataclass(frozen=True, slots=True)
class UrdfLink:
    """Link with its collision shapes, or with its visual shapes if it has none (``collides`` is false)."""

    name: str
    shapes: tuple[PlacedShape, ...]
    collides: bool


@dataclass(frozen=True, slots=True)
class Mimic:
    """``<mimic>`` of a joint, whose position is multiplier · (position of ``joint``) + offset."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True, slots=True)
class UrdfJoint:
    """Joint; ``velocity`` is its limit [rad/s or m/s], None if it is 0 or missing."""

    name: str
    type: str
    parent: str
    child: str
    origin: Rigid
    axis: tuple[float, float, float]
    velocity: float | None
    mimic: Mimic | None


@dataclass(frozen=True, slots=True)
class Urdf:
    """Robot: links and joints by name, in the order of the file."""

    name: str
    links: dict[str, UrdfLink]
    joints: dict[str, UrdfJoint]


def read_urdf(root: Element) -> Urdf:
    """Return the links and joints of a URDF.

    Parameters
    ----------
    root : Element
        Root element of the document.

    Raises
    ------
    InvalidUrdf
        It is not a URDF, or part of it is invalid; the text names the link or joint.
    """
    if root.tag != "robot":
        raise InvalidUrdf(f"the root element of a URDF must be <robot>, not <{root.tag[:64]}>")
    links, joints = root.findall("link"), root.findall("joint")
    if not links:
        raise InvalidUrdf("the robot has no <link>")
    if len(links) > MAX_LINKS or len(joints) > MAX_LINKS:
        most = max(len(links), len(joints))
        raise InvalidUrdf(f"a robot may have at most {MAX_LINKS} links and {MAX_LINKS} joints, not {most}")
    found: dict[str, UrdfLink] = {}
    for each in links:
        link = _link(each)
        if found.setdefault(link.name, link) is not link:
            raise InvalidUrdf(f"two links are named {link.name!a}")
    if (count := sum(len(link.shapes) for link in found.values())) > MAX_SHAPES:
        raise InvalidUrdf(f"a robot may have at most {MAX_SHAPES} shapes, not {count}")
    return Urdf(root.get("name", "")[:256], found, _joints(joints))


def _joints(elements: list[Element]) -> dict[str, UrdfJoint]:
    found: dict[str, UrdfJoint] = {}
    for each in elements:
        joint = _joint(each)
        if found.setdefault(joint.name, joint) is not joint:
            raise InvalidUrdf(f"two joints are named {joint.name!a}")
    return found


def _link(element: Element) -> UrdfLink:
    name = name_of(element)
    where = f"link {name!a}"
    collisions = read_shapes(element, "collision", where)
    return UrdfLink(name, collisions or read_shapes(element, "visual", where), bool(collisions))


def _joint(element: Element) -> UrdfJoint:
    name = name_of(element)
    where = f"joint {name!a}"
    kind = element.get("type", "")
    if kind not in JOINT_TYPES:
        raise InvalidUrdf(f"{where}: type= must be one of {', '.join(JOINT_TYPES)}, not {kind[:64]!a}")
    axis = element.find("axis")
    direction = (1.0, 0.0, 0.0) if axis is None else numbers(axis, "xyz", 3, where, "1 0 0")
    return UrdfJoint(
        name=name,
        type=kind,
        parent=name_of(required(element, "parent", where), "link"),
        child=name_of(required(element, "child", where), "link"),
        origin=read_origin(element, where),
        axis=(1.0, 0.0, 0.0) if kind in ("fixed", "floating") else unit(direction, where),
        velocity=_velocity(element, where),
        mimic=_mimic(element, where),
    )


def _velocity(joint: Element, where: str) -> float | None:
    limit = joint.find("limit")
    if limit is None:
        return None
    velocity = number(limit, "velocity", where, "0")
    if velocity < 0.0:
        raise InvalidUrdf(f"{where}: velocity= of <limit> must not be negative")
    return velocity or None


def _mimic(joint: Element, where: str) -> Mimic | None:
    mimic = joint.find("mimic")
    if mimic is None:
        return None
    follows = number(mimic, "multiplier", where, "1"), number(mimic, "offset", where, "0")
    return Mimic(name_of(mimic, "joint"), *follows)
