"""Kernel: decode the numbers of many plan bodies at once (``ppaas.plans.encoding.body``)."""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.plans.encoding.kernels.numbers import COUNT, MOST, NUMBERS, read_numbers

Bytes = NDArray[np.uint8]
Rows = NDArray[np.int64]
Numbers = NDArray[np.float64]
FourFloats = tuple[float, float, float, float]

FORMAT, HEX = 2, 0x20
"""Lower four bits of the first byte of a body, and its flag for an id of 16 bytes in hexadecimal."""

_START, _GOAL = NUMBERS, NUMBERS + 4

_MOST_SHIFT = 56
"""Largest shift of a count [bits]; more bytes mean damage."""


@compiled
def read_bodies_numbers(data: Bytes, first: Rows, values: Numbers, header: Rows) -> None:
    """Decode the numbers of bodies.

    Parameters
    ----------
    data : (k,) uint8 array
        The bodies, one after the other.
    first : (m + 1,) int64 array
        Begin of each body, and the end of the last.
    values : (m, ``COUNT``) float64 array
        Out: the numbers.
    header : (3, m) int64 array
        Out: for each body its number of waypoints, the number of bytes decoded, and 1 if it is damaged or has another
        format.
    """
    for plan in range(len(values)):
        begin, end = first[plan], first[plan + 1]
        header[0, plan], at = _count_behind_id(data, begin, end)
        stop = read_numbers(data, at, end, values[plan]) if at < end else end + 1
        header[1, plan], header[2, plan] = stop - begin, stop > end


@compiled
def ends_near(values: Numbers, positions: FourFloats, most: float) -> NDArray[np.bool_]:
    """Return for each plan whether both ends lie within a distance of two positions.

    Parameters
    ----------
    values : (m, ``COUNT``) float64 array
        Decoded numbers.
    positions : tuple of 4 floats
        x, y of start and goal [m].
    most : float
        Largest distance [m].
    """
    near = np.empty(len(values), np.bool_)
    for plan in range(len(values)):
        start_x, start_y = values[plan, _START] - positions[0], values[plan, _START + 1] - positions[1]
        goal_x, goal_y = values[plan, _GOAL] - positions[2], values[plan, _GOAL + 1] - positions[3]
        near[plan] = max(start_x**2 + start_y**2, goal_x**2 + goal_y**2) <= most**2
    return near


@compiled
def _count_behind_id(data: Bytes, begin: int, end: int) -> tuple[int, int]:
    """Return the number of waypoints of a body and the index after it; the body's end if it has another format."""
    if begin >= end or data[begin] & 15 != FORMAT:
        return 0, end
    at = begin + 17
    if not data[begin] & HEX:
        at = begin + 2 + (int(data[begin + 1]) if begin + 1 < end else 0)
    count, shift = 0, 0
    while at < end and data[at] >= 128:
        count |= int(data[at] & 127) << shift
        at, shift = at + 1, min(shift + 7, _MOST_SHIFT)
    if at < end:
        count |= int(data[at]) << shift
    return count, min(at + 1, end)


def warm() -> None:
    """Call the kernels once."""
    data, values = np.zeros(MOST, np.uint8), np.zeros((1, COUNT))
    data.flags.writeable = False
    read_bodies_numbers(data, np.array([0, MOST]), values, np.zeros((3, 1), np.int64))
    ends_near(values, (0.0, 0.0, 0.0, 0.0), 1.0)
