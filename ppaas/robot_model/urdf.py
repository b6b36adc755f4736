"""Parts of a URDF that navigation uses: links with their shapes and poses, and joints. http://wiki.ros.org/urdf/XML"""

from dataclasses import dataclass
from xml.etree.ElementTree import Element

from ppaas.errors import InvalidUrdf
from ppaas.robot_model.shapes import PlacedShape, read_origin, read_shapes, turned
from ppaas.robot_model.xml_document import MAX_NUMBER, name_of, number, numbers, required, unit
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


# -- poses of links with all joints at zero ----------------------------------------------------------------------------

BASE_FRAMES = ("base_footprint", "base_link")
"""Names of the base frame (REP 105 and 120): the first one that exists is used, or else the root link."""


def joint_above(urdf: Urdf) -> dict[str, UrdfJoint]:
    """Return the parent joint of each link, by the name of the link.

    Raises
    ------
    InvalidUrdf
        A joint names an unknown link, or a link is the child of two joints.
    """
    above: dict[str, UrdfJoint] = {}
    for joint in urdf.joints.values():
        for end in (joint.parent, joint.child):
            if end not in urdf.links:
                raise InvalidUrdf(f"joint {joint.name!a} names link {end!a}, which does not exist")
        other = above.setdefault(joint.child, joint)
        if other is not joint:
            raise InvalidUrdf(f"link {joint.child!a} is the child of two joints, {other.name!a} and {joint.name!a}")
    return above


def link_poses(urdf: Urdf) -> tuple[str, dict[str, Rigid]]:
    """Return the base frame, and the pose of each link in it with all joints at zero.

    Raises
    ------
    InvalidUrdf
        The links do not form a tree: a link is missing, is the child of two joints, there is not exactly one root, or
        there is a loop.
    """
    above = joint_above(urdf)
    roots = [name for name in urdf.links if name not in above]
    if len(roots) != 1:
        count = f"{len(roots)} ({', '.join(map(ascii, roots[:4]))} …)" if roots else "none: its joints close a loop"
        raise InvalidUrdf(f"a robot must have one root link; this one has {count}")
    poses = _poses_under(urdf, roots[0])
    if len(poses) < len(urdf.links):
        loose = next(name for name in urdf.links if name not in poses)
        raise InvalidUrdf(f"link {loose!a} is not connected to the root {roots[0]!a}: its joints close a loop")
    base = next((name for name in BASE_FRAMES if name in urdf.links), roots[0])
    from_base = poses[base].inverse()
    return base, {name: from_base @ poses[name] for name in urdf.links}


def rigid_links(urdf: Urdf, base: str) -> list[str]:
    """Return the links that fixed joints join with a link, in the order of the file, itself included."""
    parts = {name: name for name in urdf.links}

    def part_of(name: str) -> str:
        while parts[name] != name:
            name = parts[name]
        return name

    for joint in urdf.joints.values():
        if joint.type == "fixed":
            parts[part_of(joint.child)] = part_of(joint.parent)
    return [name for name in urdf.links if part_of(name) == part_of(base)]


def _poses_under(urdf: Urdf, root: str) -> dict[str, Rigid]:
    """Return the poses of all links below a root, in the frame of the root."""
    below: dict[str, list[UrdfJoint]] = {}
    for joint in urdf.joints.values():
        below.setdefault(joint.parent, []).append(joint)
    poses, waiting = {root: Rigid()}, [root]
    while waiting:
        parent = waiting.pop()
        for joint in below.get(parent, ()):
            poses[joint.child] = poses[parent] @ joint.origin @ _motion(urdf, joint)
            waiting.append(joint.child)
    return poses


def _motion(urdf: Urdf, joint: UrdfJoint) -> Rigid:
    """Return the displacement of a joint from its origin, with all joints that do not mimic another at zero."""
    position = _position(urdf, joint)
    if position and joint.type in TURNING:
        return turned(joint.axis, position)
    if position and joint.type == "prismatic":
        x, y, z = joint.axis
        return Rigid(position * x, position * y, position * z)
    return Rigid()


def _position(urdf: Urdf, joint: UrdfJoint) -> float:
    """Return the position of a joint by its chain of ``<mimic>`` elements, ((0·m₁ + o₁)·m₂ + o₂)… [rad or m]."""
    chain: list[UrdfJoint] = []
    while joint.mimic is not None:
        if joint in chain:
            raise InvalidUrdf(f"joint {joint.name!a} mimics itself through its chain of <mimic>")
        chain.append(joint)
        if joint.mimic.joint not in urdf.joints:
            raise InvalidUrdf(f"joint {joint.name!a} mimics joint {joint.mimic.joint!a}, which does not exist")
        joint = urdf.joints[joint.mimic.joint]
    position = 0.0
    for follower in reversed(chain):
        assert follower.mimic is not None
        position = follower.mimic.multiplier * position + follower.mimic.offset
    if not abs(position) <= MAX_NUMBER:
        raise InvalidUrdf(f"the position of joint {chain[0].name!a} by <mimic> is beyond {MAX_NUMBER:g} rad or m")
    return position
