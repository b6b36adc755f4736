"""Kernels: where an upright cylinder can be in a voxel grid.

Distances are horizontal, from the middle of a voxel to the nearest point of another, and counted in half voxels: d
voxels away along an axis is 2·|d| − 1 of them, or 0 in the same row. So their squares are whole numbers.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.maps.voxels import OCCUPIED, UNKNOWN, only_read

Bytes = NDArray[np.uint8]
Ints = NDArray[np.int32]

_FAR = np.int32(1 << 30)


@njit(cache=True, nogil=True, error_model="numpy")
def _square(steps: int) -> int:
    """Return the square of the distance so many voxels away along an axis."""
    return (2 * steps - 1) * (2 * steps - 1) if steps else 0


@njit(cache=True, nogil=True, error_model="numpy")
def _near(next_above: Ints, last: int, outside: bool, most: int, gaps: Ints, squares: Ints) -> None:
    """Set the squared distance of each column of a layer from the nearest that is hit.

    Parameters
    ----------
    next_above : (height, width) int32 array
        The lowest layer, from this one up, that would hit the robot in that column; it does up to ``last``.
    outside : bool
        Whether what lies beside the map hits it.
    most : int
        No larger squares are looked for; where all are, it is larger.
    gaps : (height, width) int32 array
        Scratch: voxels to the nearest that is hit in the same row.
    squares : (height, width) int32 array
        Out.
    """
    height, width = next_above.shape
    for row in range(height):
        gap = 0 if outside else width + most
        for column in range(width):
            gap = 0 if next_above[row, column] <= last else gap + 1
            gaps[row, column] = gap
        gap = 0 if outside else width + most
        for column in range(width - 1, -1, -1):
            gap = min(gap + 1, gaps[row, column])
            gaps[row, column] = gap
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


@njit(cache=True, nogil=True, error_model="numpy")
def inflate_layers(voxels: Bytes, layers: int, table: Bytes, costs: Bytes) -> None:
    """Set what each place costs a cylinder that stands in it.

    Parameters
    ----------
    voxels : (depth, height, width) uint8 array
        0 free, 100 occupied, 255 unknown.
    layers : int
        Layers in which the cylinder is, from its place upwards.
    table : (n,) uint8 array
        Cost by the square of the distance from an obstacle; 253 and then less.
    costs : (depth, height, width) uint8 array
        Out.
    """
    depth, height, width = voxels.shape
    solid, unknown = np.full((height, width), _FAR, np.int32), np.full((height, width), depth, np.int32)
    gaps = np.empty((height, width), np.int32)
    solid_squares, unknown_squares = np.empty((height, width), np.int32), np.empty((height, width), np.int32)
    collides = 0
    while collides < len(table) and table[collides] == INSCRIBED_INFLATED_OBSTACLE:
        collides += 1
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


@njit(cache=True, nogil=True, error_model="numpy")
def keep_to_ground(voxels: Bytes, steps: int, costs: Bytes) -> None:
    """Block the places with nothing occupied in the ``steps`` voxels below them.

    Parameters
    ----------
    voxels, costs : (depth, height, width) uint8 array
        As in ``inflate_layers``; the costs are changed.
    steps : int
        At least one.
    """
    depth, height, width = voxels.shape
    ground = np.full((height, width), -_FAR, np.int32)
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
