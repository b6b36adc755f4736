"""Slow, obvious twins of costmaps: static layer, masks, people, and costs in space."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import FREE_SPACE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.social_layer import Proxemics
from ppaas.costmap.volume import Volume
from ppaas.maps.grid import OCCUPIED_THRESHOLD, UNKNOWN, GridInfo, GridMap
from ppaas.maps.voxels import VoxelGrid


def sampled(mask: GridMap, info: GridInfo) -> NDArray[np.int8]:
    """Return the value of a mask at the centre of each cell, −1 outside the mask."""
    found = np.full(info.shape, -1, np.int8)
    for cell in np.ndindex(info.shape):
        there = mask.info.cell_of(*info.to_world(cell).tolist())
        if there is not None:
            found[cell] = mask.data[there]
    return found


def spread(mask: GridMap, info: GridInfo) -> NDArray[np.int8]:
    """Return the highest value at the centre of each cell and of the mask cells whose centres are in it."""
    found = np.maximum(sampled(mask, info), 0)
    for cell in np.ndindex(mask.info.shape):
        there = info.cell_of(*mask.info.to_world(cell).tolist())
        if there is not None:
            found[there] = max(found[there], mask.data[cell])
    return found


def cost(value: int) -> int:
    """Return the cost of a mask's value from 0 to 100: scaled to 254, with halves rounded up."""
    return int(254 * value / 100 + 0.5)


def height_mask(voxels: VoxelGrid, info: GridInfo, lowest: float, highest: float) -> NDArray[np.int8]:
    """Return 100 in cells that an occupied voxel overlaps within a range of heights; both grids are axis-aligned."""
    found = np.zeros(info.shape, np.int8)
    edge = voxels.info.resolution
    corners = info.to_world(np.moveaxis(np.indices(info.shape), 0, -1)) - info.resolution / 2
    left, bottom = corners[..., 0], corners[..., 1]
    for layer, row, column in np.argwhere(voxels.data == 100).tolist():
        x, y, z = voxels.info.to_world((layer, row, column)) - edge / 2
        if z + edge <= lowest + 1e-9 or z >= highest - 1e-9:
            continue
        beside = np.minimum(x + edge, left + info.resolution) - np.maximum(x, left)
        behind = np.minimum(y + edge, bottom + info.resolution) - np.maximum(y, bottom)
        found[np.minimum(beside, behind) > 1e-9] = 100
    return found


def static_costmap(grid: GridMap) -> Costmap:
    """Return the costmap of a map before inflation: lethal, unknown and free cells.

    Cells of 65 or more are lethal, as those that map_server makes 100 are in costmap_2d with its default
    ``lethal_cost_threshold`` and ``trinary_costmap``; graded cells below are free.
    """
    costs = np.full(grid.info.shape, FREE_SPACE, np.uint8)
    costs[grid.data >= OCCUPIED_THRESHOLD] = LETHAL_OBSTACLE
    costs[grid.data == UNKNOWN] = NO_INFORMATION
    return Costmap(costs, grid.info)


def raised(
    costs: NDArray[np.uint8], people: list[tuple[float, float, float, float]], resolution: float, how: Proxemics
) -> NDArray[np.uint8]:
    """Return the costs with people: x, y [m] from the corner of cell (0, 0), and velocities [m/s]."""
    result = costs.copy()
    for row, column in np.ndindex(costs.shape):
        if costs[row, column] == 255:
            continue
        for x, y, vx, vy in people:
            dx, dy = (column + 0.5) * resolution - x, (row + 0.5) * resolution - y
            off = math.remainder(math.atan2(dy, dx) - math.atan2(vy, vx), 2.0 * math.pi)
            in_front = abs(off) < math.pi / 2
            stretched = how.covariance * (1.0 + how.factor * math.hypot(vx, vy)) if in_front else how.covariance
            along, aside = math.cos(off) * math.hypot(dx, dy), math.sin(off) * math.hypot(dx, dy)
            cost = how.amplitude * math.exp(-(along**2 / (2 * stretched) + aside**2 / (2 * how.covariance)))
            if cost >= how.cutoff:
                result[row, column] = max(result[row, column], math.floor(cost))
    return result


Point = tuple[float, float]


def inflated(
    data: NDArray[np.uint8], edge: float, radius: float, height: float, inflation: float, factor: float
) -> NDArray[np.uint8]:
    """Return the costs of all positions of a flying cylinder; space around the grid is unknown."""
    reach = math.ceil(max(radius, inflation) / edge) + 2
    layers = max(1, math.ceil(height / edge - 1e-9))
    around = np.pad(data, ((0, layers), (reach, reach), (reach, reach)), constant_values=255)
    costs = np.zeros(data.shape, np.uint8)
    for layer, row, column in np.ndindex(data.shape):
        near, unknown = math.inf, False
        for up in range(layers):
            for down, right in np.ndindex(2 * reach + 1, 2 * reach + 1):
                voxel = around[layer + up, row + down, column + right]
                gaps = (max(0.0, (abs(offset - reach) - 0.5)) * edge for offset in (down, right))
                distance = math.hypot(*gaps)
                if voxel == 100:
                    near = min(near, distance)
                unknown |= voxel == 255 and (distance == 0.0 or distance < radius - 1e-9)
        if data[layer, row, column] == 100:
            costs[layer, row, column] = 254
        elif near == 0.0 or near < radius - 1e-9:
            costs[layer, row, column] = 253
        elif unknown:
            costs[layer, row, column] = 255
        elif near <= inflation + 1e-9:
            costs[layer, row, column] = int(252 * math.exp(-factor * max(0.0, near - radius)))
    return costs


def stands(data: NDArray[np.uint8], layer: int, row: int, column: int, edge: float, max_step: float) -> bool:
    """Return whether an occupied voxel is directly below a position, or at most ``max_step`` lower [m]."""
    return any(
        data[below, row, column] == 100 for below in range(layer) if (layer - 1 - below) * edge <= max_step + 1e-9
    )


def overlaps(volume: Volume, x: float, y: float, yaw: float, column: int, row: int, edge: float) -> bool:
    """Return whether a robot and a voxel overlap, seen from above."""
    if volume.half_length == 0.0:
        gap_x = max(column * edge - x, 0.0, x - (column + 1) * edge)
        gap_y = max(row * edge - y, 0.0, y - (row + 1) * edge)
        return math.hypot(gap_x, gap_y) < volume.radius
    c, s = math.cos(yaw), math.sin(yaw)
    corners = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    box = [(x + c * a * volume.half_length - s * b * volume.half_width,
            y + s * a * volume.half_length + c * b * volume.half_width) for a, b in corners]  # fmt: skip
    for axis, least, sign in ((0, column, 1), (0, column + 1, -1), (1, row, 1), (1, row + 1, -1)):
        box = _cut(box, axis, least * edge, sign)
    return _area(box) > 0.0


def _cut(polygon: list[Point], axis: int, bound: float, sign: int) -> list[Point]:
    """Return the part of a convex polygon beyond a bound (Sutherland and Hodgman)."""
    kept = []
    for here, there in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        a, b = sign * (here[axis] - bound), sign * (there[axis] - bound)
        if a >= 0:
            kept.append(here)
        if a * b < 0:
            part = a / (a - b)
            kept.append((here[0] + part * (there[0] - here[0]), here[1] + part * (there[1] - here[1])))
    return kept


def _area(polygon: list[Point]) -> float:
    pairs = zip(polygon, polygon[1:] + polygon[:1], strict=True)
    return abs(sum(a[0] * b[1] - a[1] * b[0] for a, b in pairs)) / 2.0


def hits(data: NDArray[np.uint8], edge: float, volume: Volume, pose: tuple[float, float, float, float]) -> bool:
    """Return whether a robot at x, y, z, yaw overlaps an occupied voxel."""
    x, y, z, yaw = pose
    return any(
        layer * edge < z + volume.height and (layer + 1) * edge > z and overlaps(volume, x, y, yaw, column, row, edge)
        for layer, row, column in np.argwhere(data == 100).tolist()
    )
