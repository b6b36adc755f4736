"""Narrow passages: cells of a costmap that are too narrow for the disc around a robot, but not for its outline.

A costmap is inflated by the circumscribed radius, so that a robot may turn everywhere. A robot that is longer than wide
fits through doors in which it cannot turn.
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE
from ppaas.costmap.costmap import Costmap
from ppaas.footprints import Footprint
from ppaas.geometry import Pose2D, Poses, convex_outline, reach_of, within_hull, yaw_of
from ppaas.kernel_threads import limit_threads
from ppaas.maps.kernels.distance import distance_parallel, distance_serial

NARROW = INSCRIBED_INFLATED_OBSTACLE - 1
"""Cost of a cell in a narrow passage, the highest of a free cell: paths lead through as few as possible."""

SMOOTHED = 0.5
"""Part of the robot's reach before and behind a pose over which its heading on a path is taken: where a path from cell
to cell turns by 45°, a robot drives on."""

AT_ONCE = 32
"""Largest number of poses in a row that are checked together."""


def with_narrow_passages(costmap: Costmap, inner_radius: float, threads: int = 1) -> Costmap:
    """Return a costmap in which cells are free that are farther from obstacles than the disc within the outline.

    Parameters
    ----------
    costmap : Costmap
        Inflated by the circumscribed radius. It is not modified.
    inner_radius : float
        Radius of the largest disc around the robot's origin within its outline [m].
    threads : int
        Maximum number of threads.
    """
    lethal = (costmap.data == LETHAL_OBSTACLE).view(np.uint8)
    with limit_threads(threads) as usable:
        distance = (distance_parallel if usable > 1 else distance_serial)(lethal, costmap.info.resolution)
    return narrowed(costmap, distance, inner_radius)


def narrowed(costmap: Costmap, distance: NDArray[np.float32], inner_radius: float) -> Costmap:
    """Return the costmap of `with_narrow_passages` by the distance of each cell to the nearest obstacle [m]."""
    data = costmap.data.copy()
    data[(data == INSCRIBED_INFLATED_OBSTACLE) & (distance > inner_radius)] = NARROW
    return replace(costmap, data=data, indexes=None, changes=None)


def fits_along(costmap: Costmap, poses: Poses, footprint: Footprint) -> bool:
    """Return whether a robot that drives along a path hits nothing where the disc around it does not fit.

    Parameters
    ----------
    costmap : Costmap
        Inflated by the circumscribed radius.
    poses : (n, 7) array
        A path. The robot heads along it, and at the last pose as that says.
    footprint : Footprint
        Outline of the robot, of which the convex hull counts.
    """
    hull = convex_outline(footprint)
    points = np.ascontiguousarray(poses[:, :2], np.float64)
    cells = costmap.info.to_cells(points)
    inside = ((cells >= 0) & (cells < costmap.info.shape)).all(axis=1)
    tight = np.flatnonzero(inside)[costmap.data[tuple(cells[inside].T)] >= INSCRIBED_INFLATED_OBSTACLE]
    headings = _headings(points, SMOOTHED * reach_of(hull))[tight]
    if len(tight) and tight[-1] == len(poses) - 1:
        tight, headings = np.append(tight, tight[-1]), np.append(headings, yaw_of(*poses[-1, 3:].tolist()))
    # Few poses at once, which are close to each other: the rectangle around all of them may be the whole map.
    runs = np.split(np.arange(len(tight)), np.flatnonzero(np.diff(tight // AT_ONCE)) + 1)
    return all(_fits(costmap, hull, points[tight[run]], headings[run]) for run in runs if len(run))


def fits_at(costmap: Costmap, pose: Pose2D, hull: NDArray[np.float64]) -> bool:
    """Return whether a robot with a convex outline, (n, 2) corners counter-clockwise [m], hits nothing at a pose."""
    return _fits(costmap, hull, np.array((pose[:2],)), np.array((pose.theta,)))


def _fits(
    costmap: Costmap, hull: NDArray[np.float64], points: NDArray[np.float64], headings: NDArray[np.float64]
) -> bool:
    """Return whether an outline at (n, 2) points [m] with (n,) headings [rad] hits nothing."""
    edge = costmap.info.resolution
    obstacles = _obstacles_near(costmap, points, reach_of(hull) + edge)
    return not any(
        _hits(hull, point, heading, obstacles, 0.5 * edge)
        for point, heading in zip(points, headings.tolist(), strict=True)
    )


def _obstacles_near(costmap: Costmap, points: NDArray[np.float64], reach: float) -> NDArray[np.float64]:
    """Return the (n, 2) centres of lethal cells in the rectangle around points [m]."""
    corners = costmap.info.to_cells(np.concatenate((points - reach, points + reach)))
    if costmap.info.origin.theta:
        wide = math.ceil(1.5 * reach / costmap.info.resolution)
        low, high = corners.min(axis=0) - wide, corners.max(axis=0) + wide
    else:
        low, high = corners.min(axis=0), corners.max(axis=0)
    low = np.maximum(low, 0)
    window = costmap.data[low[0] : high[0] + 1, low[1] : high[1] + 1]
    centres: NDArray[np.float64] = costmap.info.to_world(np.argwhere(window == LETHAL_OBSTACLE) + low)
    return centres


def _headings(points: NDArray[np.float64], around: float) -> NDArray[np.float64]:
    """Return the direction of a path at each point, from that far behind to that far ahead [rad]."""
    along = np.concatenate(((0.0,), np.cumsum(np.hypot(*np.diff(points, axis=0).T))))
    behind, ahead = (np.column_stack([np.interp(along + step, along, axis) for axis in points.T])
                     for step in (-around, around))  # fmt: skip
    chord = ahead - behind
    headings: NDArray[np.float64] = np.arctan2(chord[:, 1], chord[:, 0])
    return headings


def _hits(
    hull: NDArray[np.float64],
    point: NDArray[np.float64],
    heading: float,
    obstacles: NDArray[np.float64],
    margin: float,
) -> bool:
    """Return whether the centre of an obstacle's cell is within the outline and a margin [m]."""
    c, s = math.cos(heading), math.sin(heading)
    seen = (obstacles - point) @ np.array(((c, -s), (s, c)))
    return bool(within_hull(hull, seen[:, 0], seen[:, 1], margin).any())
