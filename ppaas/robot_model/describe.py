"""From the bytes of a URDF to what navigation must know of the robot."""

import math
from collections.abc import Mapping
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidUrdf
from ppaas.geometry import convex_outline
from ppaas.robot_model.description import Corner, RobotDescription, circumscribed_radius
from ppaas.robot_model.kinematics import BASE_FRAMES, link_poses
from ppaas.robot_model.sensors import sensor_frames, tilted
from ppaas.robot_model.shapes import Mesh, Shape, heights, outline_points
from ppaas.robot_model.urdf import Urdf, read_urdf
from ppaas.robot_model.wheels import speed_limits
from ppaas.robot_model.xml_document import MAX_BYTES, read_document
from ppaas.transforms.spatial import Rigid

__all__ = ["MAX_BYTES", "MAX_RADIUS", "describe"]

MAX_RADIUS = 100.0
"""Metres; costmaps are inflated for no larger robot."""

MAX_WARNINGS = 10

Body = list[tuple[Shape, Rigid]]


@lru_cache(maxsize=32)
def describe(data: bytes) -> RobotDescription:
    """Return what a URDF tells of a robot.

    The footprint is the convex outline, seen from above, of all that the robot collides with. A mesh counts as its
    ``bounding_box``; of a robot with one that tells none neither footprint nor height are told, since what is too
    small would be believed.

    Parameters
    ----------
    data : bytes
        The XML, in UTF-8, as xacro gives it.

    Raises
    ------
    MessageTooLarge
        It has more than ``MAX_BYTES``.
    InvalidUrdf
        It is no XML or no URDF, has entities, its links are no tree, or a number in it is none; the text says where.
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
        warnings=(*warnings, *tilted(sensors))[:MAX_WARNINGS],
    )


def _body(urdf: Urdf, poses: Mapping[str, Rigid]) -> tuple[Body, tuple[str, ...]]:
    """Return the shapes of a robot where they are, none if one is unknown, and what must be told of that."""
    links = [link for link in urdf.links.values() if link.collides]
    warnings = []
    if not links:
        links = [link for link in urdf.links.values() if link.shapes]
        instead = "what is <visual> counts" if links else "footprint and height are not known"
        warnings.append(f"no link has a <collision>: {instead}")
    body = [(placed.shape, poses[link.name] @ placed.origin) for link in links for placed in link.shapes]
    unknown = [(link.name, placed.shape) for link in links for placed in link.shapes if isinstance(placed.shape, Mesh)]
    warnings += [
        f"link {name!a} is the mesh {mesh.filename!a}, which nobody sees: give it a bounding_box= or a <collision> of "
        "simple shapes; until then footprint and height are not known"
        for name, mesh in unknown
    ]
    return ([] if unknown else body), tuple(warnings)


def _footprint(body: Body) -> tuple[Corner, ...]:
    if not body:
        return ()
    points = np.concatenate([outline_points(shape, pose) for shape, pose in body])
    outline = convex_outline(_outer(np.round(points, 6)))
    footprint = tuple((x + 0.0, y + 0.0) for x, y in outline.tolist())
    if circumscribed_radius(footprint) >= MAX_RADIUS:
        raise InvalidUrdf(f"the robot reaches {MAX_RADIUS:g} m or more: lengths are metres, and scale= is for meshes")
    return footprint if len(footprint) > 2 else ()


def _outer(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Leave out points that lie within the outline of some that reach farthest (Akl and Toussaint, 1978)."""
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
    """Return the height above the ground, which is at zero of base_footprint (REP 120), else under the lowest part."""
    if not body:
        return None
    ends = [heights(shape, pose) for shape, pose in body]
    ground = 0.0 if base == BASE_FRAMES[0] else min(low for low, _ in ends)
    height = max(high for _, high in ends) - ground
    return round(float(height), 6) if height > 0.0 else None
