"""Furniture: chairs, tables, coat stands, columns, posters and mirrors, as depth cameras and lasers see it."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.grid import OCCUPIED, GridMap
from robots.sim.bodies.body import SEAT
from robots.sim.depth.shapes import Mirror, Shapes, box, capsule, ellipsoid, nothing, shapes_of

CHAIR, TABLE, COAT_STAND, COLUMN, POSTER, MIRROR = "chair", "table", "coat_stand", "column", "poster", "mirror"
"""Kinds of furniture."""


@dataclass(frozen=True, slots=True)
class Furniture:
    """A piece of furniture.

    Parameters
    ----------
    kind : str
    pose : Pose2D
        Centre on the floor; its front is ahead.
    shapes : Shapes
        In the frame of the map.
    discs : tuple of tuple of float
        Legs and columns at the height of a laser, in the frame of the map: x, y, radius [m].
    footprint : tuple of float
        Half of the length and width of the area in which nobody walks [m], along and across the pose; 0 for none.
    mirror : Mirror, optional
    """

    kind: str
    pose: Pose2D
    shapes: Shapes
    discs: tuple[tuple[float, float, float], ...] = ()
    footprint: tuple[float, float] = (0.0, 0.0)
    mirror: Mirror | None = None


def _discs(pose: Pose2D, *local: tuple[float, float, float]) -> tuple[tuple[float, float, float], ...]:
    moved = ((pose @ Pose2D(x, y), radius) for x, y, radius in local)
    return tuple((place.x, place.y, radius) for place, radius in moved)


def chair(pose: Pose2D) -> Furniture:
    """Return a chair with four legs and a back."""
    half, thick = 0.22, 0.018
    corners = [(x, y) for x in (half - thick, thick - half) for y in (half - thick, thick - half)]
    legs = [capsule((x, y, 0.0), (x, y, SEAT - 0.02), thick) for x, y in corners]
    posts = [capsule((thick - half, y, SEAT), (-half - 0.05, y, 0.88), thick) for y in (half - thick, thick - half)]
    parts = [
        box((0.0, 0.0, SEAT - 0.02), (half, half, 0.02)),
        box((-half - 0.03, 0.0, 0.75), (0.015, half, 0.14), pitch=-0.12),
    ]
    discs = _discs(pose, *[(x, y, thick) for x, y in corners])
    return Furniture(CHAIR, pose, shapes_of(legs + posts, parts).placed(pose), discs, (0.3, 0.25))


def table(pose: Pose2D, length: float = 1.6, width: float = 0.8, height: float = 0.74) -> Furniture:
    """Return a table with four legs, ``length`` along its pose [m]."""
    corners = [
        (x, y) for x in (0.5 * length - 0.06, 0.06 - 0.5 * length) for y in (0.5 * width - 0.06, 0.06 - 0.5 * width)
    ]
    legs = [capsule((x, y, 0.0), (x, y, height - 0.03), 0.03) for x, y in corners]
    top = box((0.0, 0.0, height - 0.015), (0.5 * length, 0.5 * width, 0.015))
    discs = _discs(pose, *[(x, y, 0.03) for x, y in corners])
    return Furniture(TABLE, pose, shapes_of(legs, [top]).placed(pose), discs, (0.5 * length, 0.5 * width))


def coat_stand(pose: Pose2D, hat: bool = False) -> Furniture:
    """Return a coat stand with a coat on a hanger, as wide as a torso, and perhaps a hat at the height of a head."""
    feet = [
        capsule((0.0, 0.0, 0.03), (0.28 * math.cos(turn), 0.28 * math.sin(turn), 0.02), 0.015)
        for turn in np.linspace(0.0, 2.0 * math.pi, 4, endpoint=False).tolist()
    ]
    hooks = [
        capsule((0.0, 0.0, 1.68), (0.14 * math.cos(turn), 0.14 * math.sin(turn), 1.76), 0.01)
        for turn in np.linspace(0.0, 2.0 * math.pi, 4, endpoint=False).tolist()
    ]
    hanger = capsule((0.06, 0.17, 1.46), (0.06, -0.17, 1.46), 0.05)
    solids = [
        ellipsoid((0.06, 0.0, 1.25), (0.10, 0.22, 0.32)),
        ellipsoid((0.06, 0.0, 0.95), (0.11, 0.24, 0.35)),
    ]
    if hat:
        solids += [ellipsoid((0.0, 0.0, 1.76), (0.16, 0.16, 0.02)), ellipsoid((0.0, 0.0, 1.80), (0.09, 0.08, 0.07))]
    pole = capsule((0.0, 0.0, 0.0), (0.0, 0.0, 1.75), 0.022)
    shapes = shapes_of([pole, hanger, *feet, *hooks], solids).placed(pose)
    return Furniture(COAT_STAND, pose, shapes, _discs(pose, (0.0, 0.0, 0.022)), (0.3, 0.3))


def column(pose: Pose2D, radius: float = 0.2, height: float = 2.5) -> Furniture:
    """Return a round column [m]."""
    shapes = shapes_of([capsule((0.0, 0.0, 0.0), (0.0, 0.0, height), radius)]).placed(pose)
    return Furniture(COLUMN, pose, shapes, _discs(pose, (0.0, 0.0, radius)), (radius, radius))


def poster(pose: Pose2D) -> Furniture:
    """Return a framed poster, flat on a wall behind it."""
    return Furniture(POSTER, pose, shapes_of([], [box((0.0, 0.0, 1.5), (0.015, 0.35, 0.5))]).placed(pose))


def mirror(pose: Pose2D, width: float = 1.0, low: float = 0.3, high: float = 2.0, reflects: bool = True) -> Furniture:
    """Return a mirror, ahead of which is the room; or a pane that gives no reading."""
    first, second = pose @ Pose2D(0.0, -0.5 * width), pose @ Pose2D(0.0, 0.5 * width)
    plane = Mirror(first.x, first.y, second.x, second.y, low, high, reflects)
    return Furniture(MIRROR, pose, nothing(), mirror=plane)


def furnished(grid: GridMap, furniture: list[Furniture]) -> GridMap:
    """Return a map with the footprints of furniture occupied, for the paths of people."""
    data: NDArray[np.int8] = grid.data.copy()
    rows, columns = np.indices(data.shape)
    centres = grid.info.to_world(np.stack((rows.ravel(), columns.ravel()), axis=1))
    for piece in furniture:
        length, width = piece.footprint
        if length > 0.0:
            cosine, sine = math.cos(piece.pose.theta), math.sin(piece.pose.theta)
            right, up = centres[:, 0] - piece.pose.x, centres[:, 1] - piece.pose.y
            inside = (np.abs(cosine * right + sine * up) <= length) & (np.abs(cosine * up - sine * right) <= width)
            data.ravel()[inside] = OCCUPIED
    return GridMap(data, grid.info)
