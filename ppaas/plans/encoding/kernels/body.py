"""Kernel: what bodies of plans tell in numbers, of many at a time (``ppaas.plans.encoding.body``)."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.plans.encoding.kernels.numbers import COUNT, MOST, NUMBERS, read_numbers

Bytes = NDArray[np.uint8]
Rows = NDArray[np.int64]
Numbers = NDArray[np.float64]
Places = tuple[float, float, float, float]

FORMAT, HEX = 2, 0x20
"""In the first byte of a body: the lower four bits, and whether its id is of 16 bytes in hex."""

_FIRST, _LAST = NUMBERS, NUMBERS + 4
_MOST_SHIFT = 56


@njit(cache=True, nogil=True, error_model="numpy")
def read_bodies_numbers(data: Bytes, first: Rows, values: Numbers, places: Rows) -> None:
    """Read the numbers of bodies.

    Parameters
    ----------
    data : (k,) array
        The bodies, one after the other.
    first : (m + 1,) array
        Where each begins, and where the last ends.
    values : (m, ``COUNT``) array
        Gets them.
    places : (3, m) array
        Gets for each how many waypoints it has, how many bytes of it are read, and whether it is damaged or of another
        format.
    """
    for plan in range(len(values)):
        begin, end = first[plan], first[plan + 1]
        places[0, plan], at = _count_behind_id(data, begin, end)
        stop = read_numbers(data, at, end, values[plan]) if at < end else end + 1
        places[1, plan], places[2, plan] = stop - begin, stop > end


@njit(cache=True, nogil=True, error_model="numpy")
def ends_near(values: Numbers, places: Places, most: float) -> NDArray[np.bool_]:
    """Tell of plans whether both ends lie within a distance of two places [m].

    Parameters
    ----------
    values : (m, ``COUNT``) array
    places : tuple of 4 floats
        x, y of both [m].
    most : float
        [m]
    """
    near = np.empty(len(values), np.bool_)
    for plan in range(len(values)):
        start_x, start_y = values[plan, _FIRST] - places[0], values[plan, _FIRST + 1] - places[1]
        goal_x, goal_y = values[plan, _LAST] - places[2], values[plan, _LAST + 1] - places[3]
        near[plan] = max(start_x**2 + start_y**2, goal_x**2 + goal_y**2) <= most**2
    return near


@njit(cache=True, nogil=True, error_model="numpy")
def _count_behind_id(data: Bytes, begin: int, end: int) -> tuple[int, int]:
    """Return how many waypoints a body has, and where it goes on behind; its end if it is of another format."""
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
