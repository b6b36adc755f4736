"""Paths of cells made smooth, without coming into an obstacle."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidInput
from ppaas.geometry import Poses, poses_along
from ppaas.planners.kernels.smoothing import relax
from ppaas.planners.watch import proceed
from ppaas.planners.weights import passable

W_DATA = 0.2
W_SMOOTH = 0.3

STIFFER, LEAST, MOST = 3.0, 0.1, 100.0
"""Where a path collides it is drawn to its place by so much more, and beyond the most it stays there; in parts of
``w_smooth``."""
PER_CELL = 512
"""Points are moved by multiples of a power of two, at least so many of which are a cell: of 2⁻¹⁴ m at the usual 0.05 m.
So paths that run alike for a while become equal, however they came there, and such stretches can be kept once."""
TRIES = 4
"""After as many tries twice as many poses around each collision are taken."""


def smooth_path(
    costmap: Costmap,
    poses: Poses,
    *,
    w_data: float = W_DATA,
    w_smooth: float = W_SMOOTH,
    allow_unknown: bool = True,
    check: Callable[[], None] = proceed,
) -> Poses:
    """Return a smoother path that keeps its ends and enters no cell that is not free.

    Each pose moves to where it is drawn back to its place by ``w_data`` as strongly as to the middle between the poses
    before and after it by twice ``w_smooth``: where nav2_smoother's ``SimpleSmoother`` leaves it if it comes to rest.
    That one gives up where the path would collide; here only the poses around such a place are drawn back more
    strongly, and more of them, until nothing collides any more. Where the path itself is not free, as where it leads a
    robot away from a wall, it stays as it is.

    Parameters
    ----------
    costmap : Costmap
        Only read.
    poses : (n, 7) array
        In the frame of the costmap; poses further apart than neighbouring cells stay where they are.
    w_data, w_smooth : float
        Zero or more, and not both zero; only their ratio counts.
    allow_unknown : bool
        Whether unknown cells are free.
    check : callable
        Called between steps of the work; what it raises ends it.

    Returns
    -------
    (n, 7) array
        Each pose heads for the next one; both ends are as they were.

    Raises
    ------
    InvalidInput
        Poses that are none or not finite, or such weights.
    """
    _check_input(poses, w_data, w_smooth)
    if len(poses) < 3:
        return poses.copy()
    points = _drawn_even(costmap, poses[:, :2].copy(), (w_data, w_smooth), passable(allow_unknown), check)
    smooth = poses_along(points)
    smooth[:, 2] = poses[:, 2]
    smooth[[0, -1]] = poses[[0, -1]]
    return smooth


def _drawn_even(
    costmap: Costmap,
    points: NDArray[np.float64],
    weights: tuple[float, float],
    open_costs: NDArray[np.bool_],
    check: Callable[[], None],
) -> NDArray[np.float64]:
    """Return (n, 2) points, drawn to their places as weakly as can be; how weakly is found by trying."""
    w_data, w_smooth = weights
    near = np.full(len(points), w_data)
    near[[0, -1]] = np.inf
    found, tries = np.empty_like(points), 0
    raster = 2.0 ** math.floor(math.log2(costmap.info.resolution / PER_CELL))
    while True:
        check()
        relax(points, near, w_smooth, found)
        stays = np.isinf(near)
        found = points + np.rint((found - points) / raster) * raster
        collisions = np.flatnonzero(_hidden(costmap, found, open_costs) & ~(stays[:-1] & stays[1:]))
        if not len(collisions):
            return found
        around = 1 << tries // TRIES
        stiffer = np.zeros(len(points), np.bool_)
        for step in collisions.tolist():
            stiffer[max(0, step + 1 - around) : step + 1 + around] = True
        near[stiffer] = STIFFER * np.maximum(near[stiffer], LEAST * w_smooth)
        near[near > MOST * w_smooth] = np.inf
        tries += 1


def _hidden(costmap: Costmap, points: NDArray[np.float64], open_costs: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return for each of the n − 1 steps whether it may lead through a cell that is not free.

    A step is safe between cells that are the same or neighbours if they, and both beside a diagonal one, are free.
    """
    cells = costmap.info.to_cells(points)
    inside: NDArray[np.bool_] = np.all((cells >= 0) & (cells < costmap.info.shape), axis=1)
    row, column = np.where(inside[:, None], cells, 0).T
    beside = (row[:-1], column[:-1]), (row[1:], column[1:]), (row[:-1], column[1:]), (row[1:], column[:-1])
    safe = (np.abs(np.diff(cells, axis=0)) <= 1).all(axis=1) & inside[:-1] & inside[1:]
    for touched in beside:
        safe &= open_costs[costmap.data[touched]]
    return ~safe


def _check_input(poses: Poses, w_data: float, w_smooth: float) -> None:
    if poses.ndim != 2 or poses.shape[1:] != (7,) or not np.isfinite(poses).all():
        raise InvalidInput(f"a path is (n, 7) finite numbers, x y z and a quaternion; this one is of {poses.shape}")
    finite = math.isfinite(w_data) and math.isfinite(w_smooth)
    if not finite or min(w_data, w_smooth) < 0.0 or w_data + w_smooth == 0.0:
        raise InvalidInput(f"w_data and w_smooth are zero or more, and not both zero: not {w_data} and {w_smooth}")
