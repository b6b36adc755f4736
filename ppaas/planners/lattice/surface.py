"""Driving surface of the kinematic planner: the costmap with its own weights, prepared for footprint checks."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D
from ppaas.planners.ends import ESCAPE_DISTANCE
from ppaas.planners.lattice.kernels.driving import DrivingSurface
from ppaas.planners.lattice.parameters import LatticeParameters
from ppaas.planners.weights import FACTOR, NEUTRAL, passable

SLICE_SETUP = 1 << 20
"""Cells prepared between two checks."""

MAX_FREE_COST = INSCRIBED_INFLATED_OBSTACLE - 1
"""Highest cost of a free cell: 252."""


def reweighted_costs(parameters: LatticeParameters) -> NDArray[np.uint8]:
    """Return for each of the 256 costs the equivalent cost under the grid planners' weight, 50 + 0.8·cost.

    With it one map serves both the search over poses and the cost field that guides the search.
    """
    per_unit = parameters.cost_penalty * NEUTRAL / (FACTOR * MAX_FREE_COST)
    costs = np.minimum(np.arange(256.0) * per_unit, MAX_FREE_COST).astype(np.uint8)
    closed = ~passable(parameters.allow_unknown)
    costs[closed] = INSCRIBED_INFLATED_OBSTACLE
    costs[LETHAL_OBSTACLE] = LETHAL_OBSTACLE
    return costs


def prepare_surface(
    costmap: Costmap, start: Pose2D, parameters: LatticeParameters, check: Callable[[], None]
) -> DrivingSurface:
    """Prepare a costmap for driving.

    Parameters
    ----------
    costmap : Costmap
        Only read.
    start : Pose2D
        Start of the plan, in cells; x along the columns.
    parameters : LatticeParameters
    check : callable
        Called at least every few milliseconds; an exception from it ends the work.
    """
    resolution = costmap.info.resolution
    height, width = costmap.info.shape
    corners = parameters.outline() / resolution
    table = reweighted_costs(parameters)
    lethal = np.zeros(256, np.bool_)
    lethal[LETHAL_OBSTACLE], lethal[NO_INFORMATION] = True, not parameters.allow_unknown
    costs = np.empty((height, width), np.uint8)
    sums = np.zeros((height, width + 1) if len(corners) else (0, 0), np.int32)
    rows = max(1, SLICE_SETUP // width)
    for first in range(0, height, rows):
        check()
        band = slice(first, first + rows)
        np.take(table, costmap.data[band], out=costs[band])
        if len(corners):
            np.cumsum(lethal[costmap.data[band]], axis=1, out=sums[band, 1:])
    return DrivingSurface(
        costs=costs,
        rates=1.0 - parameters.retrospective_penalty + FACTOR / NEUTRAL * np.arange(256.0),
        corners=corners,
        reach=float(np.hypot(corners[:, 0], corners[:, 1]).max(initial=0.0)),
        sums=sums,
        outside=parameters.allow_unknown,
        x=start.x,
        y=start.y,
        escape=ESCAPE_DISTANCE / resolution,
    )
