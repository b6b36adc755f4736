"""Kernel: lay out the padded costs and the empty field, row by row."""

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from ppaas.planners.kernels.layout import BLOCKED, UNREACHED
from ppaas.planners.kernels.threads import at_most

Bytes = NDArray[np.uint8]
Open = NDArray[np.bool_]
Field = NDArray[np.uint32]


@njit(cache=True, nogil=True, error_model="numpy")
def _lay_row(source: Bytes, open_costs: Open, costs: Bytes, field: Field, row: int) -> None:
    height, width = source.shape
    costs[row, 0] = costs[row, width + 1] = 255
    field[row, 0] = field[row, width + 1] = BLOCKED
    if row in (0, height + 1):
        for column in range(1, width + 1):
            costs[row, column] = 255
            field[row, column] = BLOCKED
        return
    for column in range(1, width + 1):
        cost = source[row - 1, column - 1]
        costs[row, column] = cost
        field[row, column] = UNREACHED if open_costs[cost] else BLOCKED


@njit(cache=True, nogil=True, error_model="numpy")
def _lay_serial(source: Bytes, open_costs: Open, costs: Bytes, field: Field, first: int, last: int) -> None:
    for row in range(first, last):
        _lay_row(source, open_costs, costs, field, row)


@njit(cache=True, nogil=True, error_model="numpy", parallel=True)
def _lay_parallel(source: Bytes, open_costs: Open, costs: Bytes, field: Field, first: int, last: int) -> None:
    for row in prange(first, last):
        _lay_row(source, open_costs, costs, field, row)


def lay(source: Bytes, open_costs: Open, costs: Bytes, field: Field, first: int, last: int, threads: int) -> None:
    """Fill rows ``first`` to ``last`` of the padded arrays.

    Parameters
    ----------
    source : (height, width) uint8 array
        Costs of the map.
    open_costs : (256,) bool array
        Whether a cell of that cost may be entered.
    costs : (height + 2, width + 2) uint8 array
        Out: the same with a margin.
    field : (height + 2, width + 2) uint32 array
        Out: unreached, or blocked.
    first, last : int
        Padded rows to fill, ``last`` excluded.
    threads : int
        Most threads to use.
    """
    with at_most(threads) as usable:
        kernel = _lay_parallel if usable > 1 else _lay_serial
        kernel(source, open_costs, costs, field, first, last)


def warm() -> None:
    """Compile and call each kernel once."""
    source = np.zeros((1, 1), np.uint8)
    source.flags.writeable = False
    open_costs = np.ones(256, np.bool_)
    for cells in (source, np.zeros((1, 1), np.uint8)):
        for threads in (1, 2):
            lay(cells, open_costs, np.empty((3, 3), np.uint8), np.empty((3, 3), np.uint32), 0, 3, threads)
