"""Poses of a robot's links with all joints at zero."""

from ppaas.errors import InvalidUrdf
from ppaas.robot_model.shapes import turned
from ppaas.robot_model.urdf import TURNING, Urdf, UrdfJoint
from ppaas.robot_model.xml_document import MAX_NUMBER
from ppaas.transforms.spatial import Rigid

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
