"""Path smoothing that keeps clear of obstacles."""

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
"""Around a collision the data weight is multiplied by `STIFFER`, from at least `LEAST` on; beyond `MOST` the poses are
fixed. `LEAST` and `MOST` are multiples of ``w_smooth``."""
PER_CELL = 512
"""Least number of steps of the raster per cell. Displacements are rounded to a power of two: 2⁻¹⁴ m at the usual
resolution of 0.05 m. Paths that share a segment then become exactly equal there, so that it is stored once."""
TRIES = 4
"""Number of tries after which the range of poses around each collision doubles."""


def smooth_path(
    costmap: Costmap,
    poses: Poses,
    *,
    w_data: float = W_DATA,
    w_smooth: float = W_SMOOTH,
    allow_unknown: bool = True,
    check: Callable[[], None] = proceed,
) -> Poses:
    """Return a smoother path with the same ends, which enters no blocked cell.

    Each pose moves to the equilibrium of two forces: one towards its original position with the weight ``w_data``, one
    towards the midpoint of its neighbours with the weight 2·``w_smooth``. That is the fixed point of the iteration of
    nav2_smoother's ``SimpleSmoother``, which gives up where the smooth path would collide. Here the poses around a
    collision get a higher data weight, and more of them, until nothing collides. Where the original path is not free,
    such as on the escape from an inflated area, it is unchanged.

    Parameters
    ----------
    costmap : Costmap
        Only read.
    poses : (n, 7) array
        In the frame of the costmap. Poses that are further apart than neighbouring cells are not moved.
    w_data, w_smooth : float
        Weights, at least 0 and not both 0; only their ratio matters.
    allow_unknown : bool
        Whether unknown cells are free.
    check : callable
        Called between iterations; an exception from it ends the work.

    Returns
    -------
    (n, 7) array
        Each pose heads for the next one; both ends are unchanged.

    Raises
    ------
    InvalidInput
        The poses are not an (n, 7) array of finite numbers, or the weights are invalid.
    """
    _check_input(poses, w_data, w_smooth)
    if len(poses) < 3:
        return poses.copy()
    points = _relaxed(costmap, poses[:, :2].copy(), (w_data, w_smooth), passable(allow_unknown), check)
    smooth = poses_along(points)
    smooth[:, 2] = poses[:, 2]
    smooth[[0, -1]] = poses[[0, -1]]
    return smooth


def _relaxed(
    costmap: Costmap,
    points: NDArray[np.float64],
    weights: tuple[float, float],
    open_costs: NDArray[np.bool_],
    check: Callable[[], None],
) -> NDArray[np.float64]:
    """Return the (n, 2) smooth points; data weights are raised around collisions until there are none."""
    w_data, w_smooth = weights
    near = np.full(len(points), w_data)
    # Both ends are fixed.
    near[[0, -1]] = np.inf
    found, tries = np.empty_like(points), 0
    raster = 2.0 ** math.floor(math.log2(costmap.info.resolution / PER_CELL))
    while True:
        check()
        relax(points, near, w_smooth, found)
        stays = np.isinf(near)
        found = points + np.rint((found - points) / raster) * raster
        collisions = np.flatnonzero(_may_collide(costmap, found, open_costs) & ~(stays[:-1] & stays[1:]))
        if not len(collisions):
            return found
        around = 1 << tries // TRIES
        stiffer = np.zeros(len(points), np.bool_)
        for step in collisions.tolist():
            stiffer[max(0, step + 1 - around) : step + 1 + around] = True
        near[stiffer] = STIFFER * np.maximum(near[stiffer], LEAST * w_smooth)
        near[near > MOST * w_smooth] = np.inf
        tries += 1


def _may_collide(costmap: Costmap, points: NDArray[np.float64], open_costs: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return for each of the n − 1 steps whether it may cross a blocked cell.

    A step is safe if its ends are in the same or in neighbouring cells and both are free, as are the two cells beside a
    diagonal step.
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
        raise InvalidInput(
            f"a path must be an (n, 7) array of finite numbers, x, y, z and a quaternion, not of shape {poses.shape}"
        )
    finite = math.isfinite(w_data) and math.isfinite(w_smooth)
    if not finite or min(w_data, w_smooth) < 0.0 or w_data + w_smooth == 0.0:
        raise InvalidInput(f"w_data and w_smooth must be at least 0, and not both 0: not {w_data} and {w_smooth}")
