"""Kernel: initialize the padded costs and the empty field, layer by layer."""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.maps.voxels import only_read
from ppaas.planners.volume.kernels.layout import BLOCKED, UNREACHED


@compiled
def pad_layers(
    source: NDArray[np.uint8], open_costs: NDArray[np.bool_], costs: NDArray[np.uint8], field: NDArray[np.uint32],
    first: int, last: int,
) -> None:  # fmt: skip
    """Fill padded layers ``first`` to ``last``, ``last`` excluded.

    Parameters
    ----------
    source : (depth, height, width) uint8 array
        Costs of the map.
    open_costs : (256,) bool array
        Whether a voxel of each cost may be entered.
    costs : (depth + 2, height + 2, width + 2) uint8 array
        Out: costs with a margin.
    field : (depth + 2, height + 2, width + 2) uint32 array
        Out: `UNREACHED` or `BLOCKED`.
    first, last : int
        Range of layers.
    """
    depth, height, width = source.shape
    for layer in range(first, last):
        costs[layer] = 255
        field[layer] = BLOCKED
        if 0 < layer <= depth:
            for row in range(height):
                for column in range(width):
                    cost = source[layer - 1, row, column]
                    costs[layer, row + 1, column + 1] = cost
                    if open_costs[cost]:
                        field[layer, row + 1, column + 1] = UNREACHED


def warm() -> None:
    """Compile and call the kernel once."""
    source, shape = only_read(np.zeros((1, 1, 1), np.uint8)), (3, 3, 3)
    pad_layers(source, np.ones(256, np.bool_), np.empty(shape, np.uint8), np.empty(shape, np.uint32), 0, 3)
