"""Speed limits of a robot by the velocity limits of its wheels."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from ppaas.robot_model.kinematics import joint_above
from ppaas.robot_model.shapes import Capsule, CylinderShape, Sphere
from ppaas.robot_model.urdf import TURNING, Urdf, UrdfJoint
from ppaas.transforms.spatial import Rigid

_ALONG = 0.9
"""Least cosine between directions that count as parallel, since wheels may have some camber."""

_CENTRE = 1e-3
"""Distance from the centre line within which a wheel is neither left nor right [m]."""


class _Wheel(NamedTuple):
    speed: float
    y: float
    is_held: bool


def speed_limits(urdf: Urdf, poses: Mapping[str, Rigid]) -> tuple[float | None, float | None]:
    """Return the speed [m/s] and turning speed [rad/s] that the driven wheels allow, each None if it is unknown.

    A driven wheel is a cylinder, a capsule or a sphere on a joint with a velocity limit and an axis across the robot;
    its rim moves at radius · velocity. On the spot, the robot turns at the rim's speed divided by the wheel's distance
    from the centre line. The turning speed is unknown if wheels are on one side only, or if they steer.
    """
    above = joint_above(urdf)
    wheels = [wheel for joint in urdf.joints.values() if (wheel := _wheel(urdf, poses, above, joint)) is not None]
    if not wheels:
        return None, None
    left = any(wheel.y > _CENTRE for wheel in wheels)
    right = any(wheel.y < -_CENTRE for wheel in wheels)
    turning = None
    if left and right and all(wheel.is_held for wheel in wheels):
        turning = min(wheel.speed / abs(wheel.y) for wheel in wheels if abs(wheel.y) > _CENTRE)
    return min(wheel.speed for wheel in wheels), turning


def _wheel(urdf: Urdf, poses: Mapping[str, Rigid], above: Mapping[str, UrdfJoint], joint: UrdfJoint) -> _Wheel | None:
    if joint.type not in TURNING or joint.velocity is None:
        return None
    pose = poses[joint.child]
    axis = _direction(pose, joint.axis)
    radius = _radius(urdf, joint)
    if not radius or abs(axis[1]) < _ALONG:
        return None
    return _Wheel(radius * joint.velocity, pose.y, _is_held(above, joint.parent))


def _radius(urdf: Urdf, joint: UrdfJoint) -> float | None:
    """Return the radius of the largest shape that is a wheel on the axis of a joint [m]; None without one."""
    found = []
    for shape, origin in ((placed.shape, placed.origin) for placed in urdf.links[joint.child].shapes):
        along = abs(_dot(_direction(origin, (0.0, 0.0, 1.0)), joint.axis))
        off = math.dist(origin[:3], [_dot(origin[:3], joint.axis) * each for each in joint.axis])
        if isinstance(shape, Sphere) or (isinstance(shape, CylinderShape | Capsule) and along > _ALONG):
            found.append((off < shape.radius, shape.radius))
    return max((radius for is_round_it, radius in found if is_round_it), default=None)


def _is_held(above: Mapping[str, UrdfJoint], link: str) -> bool:
    """Return whether all joints between a link and the root are fixed."""
    while link in above:
        if above[link].type != "fixed":
            return False
        link = above[link].parent
    return True


def _direction(pose: Rigid, axis: tuple[float, float, float]) -> tuple[float, float, float]:
    turn = Rigid(qx=pose.qx, qy=pose.qy, qz=pose.qz, qw=pose.qw)
    return (turn @ Rigid(*axis))[:3]


def _dot(a: Sequence[float], b: Sequence[float]) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
