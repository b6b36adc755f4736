"""Kernel: collision check along a path, of all voxels that the robot's volume overlaps.

All lengths are in voxels. ``sizes`` has half the length, half the width, the radius and the height of the robot: a
cylinder has no length and width, a box has no radius.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.maps.voxels import OCCUPIED, UNKNOWN, only_read

Floats = NDArray[np.float64]

_SLACK = 1e-6
"""Tolerance for rounding, so that touching does not count as overlap [voxels]."""


@compiled
def _overlaps(right: float, up: float, yaw: float, sizes: Floats) -> bool:
    """Return whether a robot at (0, 0) overlaps the unit square centred at (``right``, ``up``), seen from above."""
    half_length, half_width, radius = sizes[0], sizes[1], sizes[2] - _SLACK
    if half_length == 0.0:  # a disc: distance from its centre to the square
        gap_x, gap_y = max(abs(right) - 0.5, 0.0), max(abs(up) - 0.5, 0.0)
        within = abs(right) < 0.5 - _SLACK and abs(up) < 0.5 - _SLACK
        return bool(within or (radius > 0.0 and gap_x * gap_x + gap_y * gap_y < radius * radius))
    # Separating axis theorem: two rectangles overlap if their projections on all four face normals overlap.
    c, s = math.cos(yaw), math.sin(yaw)
    half = 0.5 * (abs(c) + abs(s)) - _SLACK
    return bool(
        abs(right) < half_length * abs(c) + half_width * abs(s) + 0.5 - _SLACK
        and abs(up) < half_length * abs(s) + half_width * abs(c) + 0.5 - _SLACK
        and abs(c * right + s * up) < half_length + half
        and abs(c * up - s * right) < half_width + half
    )


@compiled
def _hits(
    voxels: NDArray[np.uint8], x: float, y: float, z: float, yaw: float, sizes: Floats, allow_unknown: bool
) -> bool:
    """Return whether a robot overlaps an occupied voxel or, unless ``allow_unknown``, an unknown or outside one."""
    depth, height, width = voxels.shape
    # Bounding box of the robot, as ranges of layers, rows and columns.
    reach = max(sizes[2], math.hypot(sizes[0], sizes[1]))
    lows = (math.floor(z + _SLACK), math.floor(y - reach + _SLACK), math.floor(x - reach + _SLACK))
    highs = (math.ceil(z + sizes[3] - _SLACK), math.ceil(y + reach - _SLACK), math.ceil(x + reach - _SLACK))
    if not allow_unknown and (lows[0] < 0 or highs[0] > depth):
        return True
    for row in range(lows[1], max(highs[1], lows[1] + 1)):
        for column in range(lows[2], max(highs[2], lows[2] + 1)):
            inside = 0 <= row < height and 0 <= column < width
            if (allow_unknown and not inside) or not _overlaps(column + 0.5 - x, row + 0.5 - y, yaw, sizes):
                continue
            if not inside:
                return True
            for layer in range(max(lows[0], 0), min(highs[0], depth)):
                voxel = voxels[layer, row, column]
                if voxel == OCCUPIED or (voxel == UNKNOWN and not allow_unknown):
                    return True
    return False


@compiled
def first_hit(
    voxels: NDArray[np.uint8], points: Floats, yaws: Floats, sizes: Floats, steps: int, allow_unknown: bool
) -> int:
    """Return the index of the first pose that collides, or that cannot be reached from the pose before; −1 if none.

    Parameters
    ----------
    voxels : (depth, height, width) uint8 array
        0 free, 100 occupied, 255 unknown.
    points : (n, 3) float64 array
        x, y, z of the poses, from the corner of voxel (0, 0, 0).
    yaws : (n,) float64 array
        Headings of the poses [rad].
    sizes : (4,) float64 array
        Half the length, half the width, the radius and the height of the robot.
    steps : int
        Number of checks per voxel edge that the robot or its corners move.
    allow_unknown : bool
        Whether the robot may overlap unknown voxels and space outside the grid.
    """
    corner = math.hypot(sizes[0], sizes[1])
    for pose in range(len(points)):
        before = max(pose - 1, 0)
        x, y, z, yaw = points[before, 0], points[before, 1], points[before, 2], yaws[before]
        # Straight move to the pose, with the heading of the pose before.
        move_x, move_y, move_z = points[pose, 0] - x, points[pose, 1] - y, points[pose, 2] - z
        checks = math.ceil(steps * math.sqrt(move_x * move_x + move_y * move_y + move_z * move_z))
        for check in range(1, checks + 1):
            part = check / checks
            if _hits(voxels, x + part * move_x, y + part * move_y, z + part * move_z, yaw, sizes, allow_unknown):
                return pose
        # Turn on the spot to the heading of the pose.
        turn = (yaws[pose] - yaw + math.pi) % (2.0 * math.pi) - math.pi
        checks = math.ceil(steps * abs(turn) * corner)
        for check in range(checks + 1):
            part = check / checks if checks else 1.0
            if _hits(
                voxels, points[pose, 0], points[pose, 1], points[pose, 2], yaw + part * turn, sizes, allow_unknown
            ):
                return pose
    return -1


def warm() -> None:
    """Compile and call the kernel once."""
    first_hit(only_read(np.zeros((1, 1, 1), np.uint8)), np.zeros((1, 3)), np.zeros(1), np.ones(4), 1, True)
