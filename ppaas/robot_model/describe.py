"""Description of a robot for navigation, from its URDF, with speed limits by the limits of its wheels."""

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidUrdf
from ppaas.geometry import convex_outline
from ppaas.robot_model.description import Corner, RobotDescription, SensorFrame, circumscribed_radius
from ppaas.robot_model.sensors import sensor_frames, tilted
from ppaas.robot_model.shapes import Capsule, CylinderShape, Mesh, Shape, Sphere, heights, outline_points
from ppaas.robot_model.urdf import (
    BASE_FRAMES,
    TURNING,
    Urdf,
    UrdfJoint,
    joint_above,
    link_poses,
    read_urdf,
    rigid_links,
)
from ppaas.robot_model.xml_document import MAX_BYTES, read_document
from ppaas.transforms.spatial import Rigid

# -- speed limits by the velocity limits of the wheels -----------------------------------------------------------------

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


# -- the description ---------------------------------------------------------------------------------------------------

__all__ = ["MAX_BYTES", "MAX_RADIUS", "describe"]

MAX_RADIUS = 100.0
"""Limit of a robot's circumscribed radius, for the inflation of costmaps [m]."""

MAX_WARNINGS = 10

MAX_FRAMES = 250
"""Limit of the frames of a description, sensors first."""

FAST = 2.0
"""Speed above which a limit of the wheels is more likely a placeholder than a robot's speed [m/s]."""

Body = list[tuple[Shape, Rigid]]
"""Shapes of a robot, each with its pose in the base frame."""


@lru_cache(maxsize=32)
def describe(data: bytes) -> RobotDescription:
    """Return the description of a robot from its URDF.

    The footprint is the convex hull, seen from above, of all collision shapes. A mesh counts as its ``bounding_box``.
    If a mesh has none, footprint and height are unknown, since a too small footprint would cause collisions.

    Parameters
    ----------
    data : bytes
        XML in UTF-8, as xacro writes it.

    Raises
    ------
    MessageTooLarge
        The file has more than ``MAX_BYTES``.
    InvalidUrdf
        The file is not XML or not a URDF, it has entities, its links do not form a tree, or a number is invalid; the
        text says where.
    """
    root = read_document(data)
    urdf = read_urdf(root)
    base, poses = link_poses(urdf)
    body, warnings = _body(urdf, poses)
    speed, turn = speed_limits(urdf, poses)
    sensors = sensor_frames(root, poses)
    return RobotDescription(
        name=urdf.name,
        base_frame=base,
        links=len(urdf.links),
        footprint=_footprint(body),
        height=_height(body, base),
        max_vel_x=speed,
        max_vel_theta=turn,
        sensors=sensors,
        warnings=(*tilted(sensors, poses), *warnings, *_too_fast(speed))[:MAX_WARNINGS],
        frames=_frames(urdf, base, poses, sensors),
    )


def _frames(
    urdf: Urdf, base: str, poses: Mapping[str, Rigid], sensors: Iterable[SensorFrame]
) -> tuple[tuple[str, Rigid], ...]:
    """Return the frames of sensors and of links that do not move, with their poses in the base frame."""
    bases = [name for name in BASE_FRAMES if name in poses]
    names = dict.fromkeys((*bases, *(sensor.link for sensor in sensors), *rigid_links(urdf, base)))
    return tuple((name, poses[name]) for name in list(names)[:MAX_FRAMES])


def _too_fast(speed: float | None) -> list[str]:
    if speed is None or speed <= FAST:
        return []
    return [
        f"the <limit velocity=> of the wheels allows {speed:.2g} m/s: the robot is driven no faster than its model, "
        "unless max_vel_x of its local planner says so"
    ]


def _body(urdf: Urdf, poses: Mapping[str, Rigid]) -> tuple[Body, tuple[str, ...]]:
    """Return the shapes of a robot, none if the extent of one is unknown, and warnings for the user."""
    links = [link for link in urdf.links.values() if link.collides]
    warnings = []
    if not links:
        links = [link for link in urdf.links.values() if link.shapes]
        instead = "<visual> shapes are used" if links else "footprint and height are unknown"
        warnings.append(f"no link has a <collision>: {instead}")
    body = [(placed.shape, poses[link.name] @ placed.origin) for link in links for placed in link.shapes]
    unknown = [(link.name, placed.shape) for link in links for placed in link.shapes if isinstance(placed.shape, Mesh)]
    if unknown:
        (name, mesh), more = unknown[0], len(unknown) - 1
        others = f" and of {more} more" if more else ""
        warnings.append(
            f"link {name!a}: the extent of mesh {mesh.filename!a}{others} is unknown, and so are footprint and height: "
            "upload the URDF with --mesh-folder, give each mesh a bounding_box=, or set robot_radius of "
            "global_costmap; until then the robot is driven with the radius of its model"
        )
    return ([] if unknown else body), tuple(warnings)


def _footprint(body: Body) -> tuple[Corner, ...]:
    if not body:
        return ()
    points = np.concatenate([outline_points(shape, pose) for shape, pose in body])
    outline = convex_outline(_outer(np.round(points, 6)))
    footprint = tuple((x + 0.0, y + 0.0) for x, y in outline.tolist())
    if circumscribed_radius(footprint) >= MAX_RADIUS:
        raise InvalidUrdf(
            f"the robot reaches {MAX_RADIUS:g} m or more from its base: lengths must be in metres; scale= applies to "
            "meshes only"
        )
    return footprint if len(footprint) > 2 else ()


def _outer(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Remove points inside the polygon of the 16 farthest points, which the hull needs not (Akl, Toussaint, 1978)."""
    angles = np.arange(16) * (math.pi / 8.0)
    farthest = points[(points @ np.array([np.cos(angles), np.sin(angles)])).argmax(axis=0)]
    corners = convex_outline(farthest)
    if len(corners) < 3:
        return points
    inside = np.ones(len(points), np.bool_)
    for (ax, ay), (bx, by) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        inside &= (bx - ax) * (points[:, 1] - ay) - (by - ay) * (points[:, 0] - ax) > 0.0
    return points[~inside]


def _height(body: Body, base: str) -> float | None:
    """Return the height above the ground [m]; None if it is unknown.

    The ground is at z = 0 of base_footprint (REP 120), or else at the lowest point of the robot.
    """
    if not body:
        return None
    ends = [heights(shape, pose) for shape, pose in body]
    ground = 0.0 if base == BASE_FRAMES[0] else min(low for low, _ in ends)
    height = max(high for _, high in ends) - ground
    return round(float(height), 6) if height > 0.0 else None
