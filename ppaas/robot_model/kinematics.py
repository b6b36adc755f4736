"""Where the links of a robot are when all its joints are at zero."""

from ppaas.errors import InvalidUrdf
from ppaas.robot_model.shapes import turned
from ppaas.robot_model.urdf import TURNING, Urdf, UrdfJoint
from ppaas.robot_model.xml_document import MAX_NUMBER
from ppaas.transforms.spatial import Rigid

BASE_FRAMES = ("base_footprint", "base_link")
"""The frame that drives (REP 105 and 120): the first of these that there is, else the root."""


def joint_above(urdf: Urdf) -> dict[str, UrdfJoint]:
    """Return the joint that holds each link, by link.

    Raises
    ------
    InvalidUrdf
        A joint names a link that there is not, or one link hangs on two joints.
    """
    above: dict[str, UrdfJoint] = {}
    for joint in urdf.joints.values():
        for end in (joint.parent, joint.child):
            if end not in urdf.links:
                raise InvalidUrdf(f"joint {joint.name!a} names the link {end!a}, which there is not")
        other = above.setdefault(joint.child, joint)
        if other is not joint:
            raise InvalidUrdf(f"link {joint.child!a} hangs on two joints, {other.name!a} and {joint.name!a}")
    return above


def link_poses(urdf: Urdf) -> tuple[str, dict[str, Rigid]]:
    """Return the base frame, and where each link is in it, all joints at zero.

    Raises
    ------
    InvalidUrdf
        The links are no tree: a link is missing, hangs on two joints, there are several roots or none, or a loop.
    """
    above = joint_above(urdf)
    roots = [name for name in urdf.links if name not in above]
    if len(roots) != 1:
        told = f"{len(roots)} ({', '.join(map(ascii, roots[:4]))} …)" if roots else "none: its joints close a loop"
        raise InvalidUrdf(f"the links of a robot hang on one root, and here are {told}")
    poses = _poses_under(urdf, roots[0])
    if len(poses) < len(urdf.links):
        loose = next(name for name in urdf.links if name not in poses)
        raise InvalidUrdf(f"link {loose!a} does not hang on the root {roots[0]!a}: its joints close a loop")
    base = next((name for name in BASE_FRAMES if name in urdf.links), roots[0])
    from_base = poses[base].inverse()
    return base, {name: from_base @ poses[name] for name in urdf.links}


def _poses_under(urdf: Urdf, root: str) -> dict[str, Rigid]:
    """Return where the links that hang on a root are in its frame."""
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
    """Return how far a joint is from its origin where all that do not follow another are at zero."""
    position = _position(urdf, joint)
    if position and joint.type in TURNING:
        return turned(joint.axis, position)
    if position and joint.type == "prismatic":
        x, y, z = joint.axis
        return Rigid(position * x, position * y, position * z)
    return Rigid()


def _position(urdf: Urdf, joint: UrdfJoint) -> float:
    """Follow mimics to who does not: ((0·m₁ + o₁)·m₂ + o₂)…"""
    chain: list[UrdfJoint] = []
    while joint.mimic is not None:
        if joint in chain:
            raise InvalidUrdf(f"joint {joint.name!a} follows itself by <mimic>")
        chain.append(joint)
        if joint.mimic.joint not in urdf.joints:
            raise InvalidUrdf(f"joint {joint.name!a} follows {joint.mimic.joint!a}, which there is not")
        joint = urdf.joints[joint.mimic.joint]
    position = 0.0
    for follower in reversed(chain):
        assert follower.mimic is not None
        position = follower.mimic.multiplier * position + follower.mimic.offset
    if not abs(position) <= MAX_NUMBER:
        raise InvalidUrdf(f"joint {chain[0].name!a} follows others by <mimic> beyond {MAX_NUMBER:g} rad or m")
    return position
