"""Twins of the laser and the depth camera: each ray is followed in small steps to what it hits."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.grid import OCCUPIED_THRESHOLD, GridMap
from robots.sim.depth.camera import DepthCameraModel
from robots.sim.depth.shapes import BOX, Shapes


def measure(
    grid: GridMap,
    pose: Pose2D,
    angles: NDArray[np.float64],
    discs: list[tuple[float, float, float]],
    range_max: float,
    step: float = 0.002,
) -> NDArray[np.float64]:
    """Return the ranges to walls and to discs (x, y, radius), to within a step; infinite without a hit."""
    ranges = np.full(len(angles), np.inf)
    for beam, angle in enumerate(angles):
        distance = 0.0
        while distance <= range_max:
            x = pose.x + distance * math.cos(pose.theta + angle)
            y = pose.y + distance * math.sin(pose.theta + angle)
            cell = grid.info.cell_of(x, y)
            in_wall = cell is not None and grid.data[cell] >= OCCUPIED_THRESHOLD
            if in_wall or any(math.hypot(x - cx, y - cy) <= radius for cx, cy, radius in discs):
                ranges[beam] = distance
                break
            distance += step
    return ranges


Floats = NDArray[np.float64]


def inside(shapes: Shapes, points: Floats) -> NDArray[np.bool_]:
    """Return whether each of (n, 3) points is inside a shape."""
    found = np.zeros(len(points), bool)
    for *ends, radius in shapes.capsules.tolist():
        start, end = np.array(ends[:3]), np.array(ends[3:])
        share = np.clip((points - start) @ (end - start) / max((end - start) @ (end - start), 1e-12), 0.0, 1.0)
        found |= np.linalg.norm(points - start - share[:, None] * (end - start), axis=1) <= radius
    for solid in shapes.solids:
        local = (points - solid[1:4]) @ solid[4:].reshape(3, 3).T
        found |= (np.abs(local).max(axis=1) if solid[0] == BOX else np.linalg.norm(local, axis=1)) <= 1.0
    return found


def depths(
    grid: GridMap, pose: Pose2D, model: DepthCameraModel, shapes: Shapes, wall_height: float, step: float = 0.008
) -> Floats:
    """Return the depth of each pixel, (height, width) [m], to within a step; infinite where nothing is hit."""
    u, v = model.slopes
    optical = np.stack(np.broadcast_arrays(u[None, :], v[:, None], 1.0), axis=2).reshape(-1, 3)
    cosine, sine = np.cos(pose.theta), np.sin(pose.theta)
    to_map = np.array(((cosine, -sine, 0.0), (sine, cosine, 0.0), (0.0, 0.0, 1.0)))
    rays = optical @ (to_map @ model.rotation.T).T
    eye = np.array((pose.x, pose.y, 0.0)) + to_map @ (model.x, model.y, model.z)
    found = np.full(len(rays), np.inf)
    for depth in np.arange(step, model.range_max + step, step):
        left = np.isinf(found)
        points = eye + depth * rays[left]
        cells = grid.info.to_cells(points[:, :2])
        within = ((cells >= 0) & (cells < grid.info.shape)).all(axis=1)
        wall = np.zeros(len(points), bool)
        wall[within] = grid.data[tuple(cells[within].T)] >= OCCUPIED_THRESHOLD
        hit = (points[:, 2] <= 0.0) | (wall & (points[:, 2] <= wall_height)) | inside(shapes, points)
        found[np.flatnonzero(left)[hit]] = depth
    return found.reshape(model.height, model.width)


def lit(inverse: Floats, parallax: float, slack: float) -> NDArray[np.bool_]:
    """Return which pixels the projector lights: none further right is seen further left by the projector."""
    found = np.ones(inverse.shape, bool)
    for row, nearness in enumerate(inverse):
        seen = np.arange(nearness.size) - parallax * nearness
        for column in range(nearness.size):
            found[row, column] = all(seen[column] <= seen[other] + slack for other in range(column + 1, nearness.size))
    return found
