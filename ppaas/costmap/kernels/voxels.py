"""Kernels: costs of an upright cylinder in a voxel grid.

Distances are horizontal, from the centre of a voxel to the nearest point of another, in half voxels: along one axis,
d voxels away is 2·|d| − 1, and 0 in the same column. So squared distances are integers.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.kernel_cache.decorators import compiled
from ppaas.maps.voxels import OCCUPIED, UNKNOWN, only_read

Bytes = NDArray[np.uint8]
Ints = NDArray[np.int32]

_FAR = np.int32(1 << 30)
"""Number of a layer beyond all layers."""


@compiled
def _square(steps: int) -> int:
    """Return the squared distance of a voxel that is ``steps`` voxels away along one axis [squared half voxels]."""
    return (2 * steps - 1) * (2 * steps - 1) if steps else 0


@compiled
def _near(next_above: Ints, last: int, outside: bool, most: int, gaps: Ints, squares: Ints) -> None:
    """Write the squared horizontal distance of each column from the nearest column that hits the robot.

    Parameters
    ----------
    next_above : (height, width) int32 array
        Lowest layer of an obstacle in each column, from the robot's layer upwards.
    last : int
        Highest layer of the robot; a column hits it if ``next_above`` is at most this.
    outside : bool
        Whether columns outside the map hit the robot.
    most : int
        Largest squared distance of interest; larger ones are written as ``most + 1``.
    gaps : (height, width) int32 array
        Scratch: distance to the nearest hitting column of the same row [voxels].
    squares : (height, width) int32 array
        Out: squared distances [squared half voxels].
    """
    height, width = next_above.shape
    # First pass: distances within each row, from the left and from the right.
    for row in range(height):
        gap = 0 if outside else width + most
        for column in range(width):
            gap = 0 if next_above[row, column] <= last else gap + 1
            gaps[row, column] = gap
        gap = 0 if outside else width + most
        for column in range(width - 1, -1, -1):
            gap = min(gap + 1, gaps[row, column])
            gaps[row, column] = gap
    # Second pass: the minimum over the rows, the nearest first, until farther rows cannot lower it.
    for row in range(height):
        for column in range(width):
            best = most + 1
            for steps in range(height + 1):
                across = _square(steps)
                if across >= best:
                    break
                for near in (row - steps, row + steps):
                    if 0 <= near < height:
                        along = int(gaps[near, column])
                        if along <= most:
                            best = min(best, across + _square(along))
                    elif outside:
                        best = min(best, across)
            squares[row, column] = best


@compiled
def inflate_layers(voxels: Bytes, layers: int, table: Bytes, costs: Bytes) -> None:
    """Write the cost of each position for a cylinder that stands there.

    Parameters
    ----------
    voxels : (depth, height, width) uint8 array
        0 free, 100 occupied, 255 unknown.
    layers : int
        Height of the cylinder, from its position upwards [layers].
    table : (n,) uint8 array
        Cost by the squared distance from an obstacle [squared half voxels]: 253 up to the radius, then lower.
    costs : (depth, height, width) uint8 array
        Out: values of costmap_2d.
    """
    depth, height, width = voxels.shape
    # Lowest occupied and lowest unknown layer of each column, from the current layer upwards; above the map is unknown.
    solid, unknown = np.full((height, width), _FAR, np.int32), np.full((height, width), depth, np.int32)
    gaps = np.empty((height, width), np.int32)
    solid_squares, unknown_squares = np.empty((height, width), np.int32), np.empty((height, width), np.int32)
    collides = 0  # least squared distance without a collision
    while collides < len(table) and table[collides] == INSCRIBED_INFLATED_OBSTACLE:
        collides += 1
    # Layers from the top to the bottom.
    for layer in range(depth - 1, -1, -1):
        for row in range(height):
            for column in range(width):
                if voxels[layer, row, column] == OCCUPIED:
                    solid[row, column] = layer
                elif voxels[layer, row, column] == UNKNOWN:
                    unknown[row, column] = layer
        _near(solid, layer + layers - 1, False, len(table) - 1, gaps, solid_squares)
        _near(unknown, layer + layers - 1, True, collides - 1, gaps, unknown_squares)
        for row in range(height):
            for column in range(width):
                square = solid_squares[row, column]
                cost = table[square] if square < len(table) else np.uint8(0)
                if voxels[layer, row, column] == OCCUPIED:
                    cost = np.uint8(LETHAL_OBSTACLE)
                elif cost != INSCRIBED_INFLATED_OBSTACLE and unknown_squares[row, column] < collides:
                    cost = np.uint8(NO_INFORMATION)
                costs[layer, row, column] = cost


@compiled
def keep_to_ground(voxels: Bytes, steps: int, costs: Bytes) -> None:
    """Block the positions without an occupied voxel among the ``steps`` voxels below them.

    Parameters
    ----------
    voxels, costs : (depth, height, width) uint8 array
        As in ``inflate_layers``; the costs are modified.
    steps : int
        At least 1.
    """
    depth, height, width = voxels.shape
    ground = np.full((height, width), -_FAR, np.int32)  # highest occupied layer of each column below the current one
    for layer in range(depth):
        for row in range(height):
            for column in range(width):
                if voxels[layer, row, column] == OCCUPIED:
                    ground[row, column] = layer
                elif layer - ground[row, column] > steps:
                    costs[layer, row, column] = INSCRIBED_INFLATED_OBSTACLE


def warm() -> None:
    """Compile and call each kernel once."""
    voxels, costs = only_read(np.zeros((1, 1, 1), np.uint8)), np.zeros((1, 1, 1), np.uint8)
    inflate_layers(voxels, 1, np.array([INSCRIBED_INFLATED_OBSTACLE, 0], np.uint8), costs)
    keep_to_ground(voxels, 1, costs)
