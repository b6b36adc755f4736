"""Kernels: poses of a path of cells, on several threads, and its cost."""

import math
from typing import Any

import numpy as np
from numba import prange
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

BLOCK = 4096
"""Cells in a parallel task: about 10 µs of work."""

Int = int | np.signedinteger[Any]
Cells = NDArray[np.int32]
Costs = NDArray[np.uint8]
Floats = NDArray[np.float64]


@compiled
def _fill_block(cells: Cells, frame: Floats, headings: Floats, poses: Floats, block: Int) -> None:
    resolution, left, bottom, cosine, sine = frame[0], frame[1], frame[2], frame[3], frame[4]
    for at in range(block * BLOCK, min((block + 1) * BLOCK, len(cells))):
        down, right = 0, 0
        if at + 1 < len(cells):
            down, right = cells[at + 1, 0] - cells[at, 0], cells[at + 1, 1] - cells[at, 1]
        y, x = (cells[at, 0] + 0.5) * resolution, (cells[at, 1] + 0.5) * resolution
        poses[at, 0] = cosine * x - sine * y + left
        poses[at, 1] = sine * x + cosine * y + bottom
        poses[at, 2] = poses[at, 3] = poses[at, 4] = 0.0
        poses[at, 5], poses[at, 6] = headings[down + 1, right + 1, 0], headings[down + 1, right + 1, 1]


@compiled(parallel=True)
def fill_poses(cells: Cells, frame: Floats, headings: Floats, poses: Floats, threads: int) -> None:
    """Compute a pose at the centre of each cell, heading for the next one.

    Parameters
    ----------
    cells : (n, 2) int32 array
        Row, column, each a neighbour of the one before.
    frame : (5,) array
        Resolution [m], x and y of the origin [m], cosine and sine of its heading.
    headings : (3, 3, 2) array
        qz, qw of each move; index = its rows + 1, its columns + 1. The last pose has the heading of no move, (0, 0).
    poses : (n, 7) array
        Out: x, y, z and quaternion.
    threads : int
        With one thread, no parallel region is entered.
    """
    blocks = (len(cells) + BLOCK - 1) // BLOCK
    if threads == 1 or blocks == 1:
        for block in range(blocks):
            _fill_block(cells, frame, headings, poses, block)
    else:
        for block in prange(blocks):
            _fill_block(cells, frame, headings, poses, block)


@compiled
def add_costs(cells: Cells, costs: Costs, weights: Floats) -> float:
    """Return the cost of a path.

    Parameters
    ----------
    cells : (n, 2) int32 array
        Row, column, each a neighbour of the one before.
    costs : (n,) uint8 array
        Costs of these cells.
    weights : (256,) array
        Weight of each cost; a move weighs as much as the cell that it leaves.
    """
    cost = 0.0
    for at in range(len(cells) - 1):
        slanted = cells[at + 1, 0] != cells[at, 0] and cells[at + 1, 1] != cells[at, 1]
        cost += weights[costs[at]] * (math.sqrt(2.0) if slanted else 1.0)
    return cost


def warm() -> None:
    """Compile and call each kernel once."""
    cells, headings, weights = np.zeros((1, 2), np.int32), np.zeros((3, 3, 2)), np.zeros(256)
    headings.flags.writeable = False
    fill_poses(cells, np.zeros(5), headings, np.zeros((1, 7)), 1)
    add_costs(cells, np.zeros(1, np.uint8), weights)
