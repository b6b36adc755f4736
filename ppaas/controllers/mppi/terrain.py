"""Terrain of MPPI rollouts: distance to obstacles and travel time to the goal in each cell of the local costmap."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.controllers.base import ControlRequest, NoValidControl
from ppaas.controllers.followed_path import FollowedPath
from ppaas.controllers.kernels.mppi import Terrain, fill_blocked
from ppaas.controllers.mppi.parameters import MppiParameters
from ppaas.controllers.obstacles import distance_to_lethal
from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D
from ppaas.planners.field.cost_field import CostField
from ppaas.planners.weights import FACTOR, NEUTRAL, passable

HIGHEST = INSCRIBED_INFLATED_OBSTACLE - 1
"""Highest cost of a cell that a robot may enter."""

FAR = 1e3
"""Travel time of cells from which no path leads to the goal [s]."""


def terrain_of(request: ControlRequest, path: FollowedPath, parameters: MppiParameters) -> Terrain:
    """Return the terrain of this cycle.

    Travel times are for the cheapest path, at full speed, to the last free point of the plan within the costmap;
    cells near obstacles cost more, as for global planners.

    Raises
    ------
    NoValidControl
        No point of the plan is free, or no path leads there from the robot.
    """
    costmap = _with_way_out(request.costmap, request.pose, parameters.robot_radius)
    resolution = costmap.info.resolution
    field = CostField(costmap, _end(request.costmap, path, parameters), allow_unknown=parameters.allow_unknown)
    field.grow()
    seconds = (field.values() * (resolution / (NEUTRAL * parameters.max_vel_x))).astype(np.float32)
    here = costmap.info.cell_of(request.pose.x, request.pose.y)
    if here is None or not math.isfinite(seconds[here]):
        raise NoValidControl("no path leads along the plan within the local costmap; plan again or recover")
    worst = resolution * (NEUTRAL + FACTOR * HIGHEST) / (NEUTRAL * parameters.max_vel_x)
    fill_blocked(seconds, worst, FAR)
    distance = distance_to_lethal(costmap, allow_unknown=parameters.allow_unknown)
    return Terrain(distance, seconds, resolution, _movers(request, parameters.command_delay))


def _with_way_out(costmap: Costmap, pose: Pose2D, radius: float) -> Costmap:
    """Return the costmap, with inscribed cells around the robot opened if it stands in one, so that it can leave."""
    here = costmap.info.cell_of(pose.x, pose.y)
    if here is None:
        raise NoValidControl("the robot is outside its local costmap; stop until localization is corrected")
    if costmap.data[here] != INSCRIBED_INFLATED_OBSTACLE:
        return costmap
    data = costmap.data.copy()
    reach = math.ceil(2.0 * radius / costmap.info.resolution)
    around = data[max(here[0] - reach, 0) : here[0] + reach + 1, max(here[1] - reach, 0) : here[1] + reach + 1]
    around[around == INSCRIBED_INFLATED_OBSTACLE] = HIGHEST
    return Costmap(data, costmap.info)


def _movers(request: ControlRequest, delay: float) -> NDArray[np.float64]:
    """Return moving obstacles (m, 5) at the time of the next command: x, y, vx, vy, radius in the grid's frame."""
    frame = request.costmap.info.origin.inverse()
    turn = Pose2D(0.0, 0.0, frame.theta)
    rows = np.empty((len(request.movers), 5))
    for row, mover in zip(rows, request.movers, strict=True):
        position, velocity = frame @ Pose2D(*mover.after(delay)[:2]), turn @ Pose2D(mover.vx, mover.vy)
        row[:] = position.x, position.y, velocity.x, velocity.y, mover.radius
    return rows


def _end(costmap: Costmap, path: FollowedPath, parameters: MppiParameters) -> NDArray[np.int64]:
    """Return row, column of the last free cell of the plan within the costmap, as one row."""
    points, _ = path.ahead(math.inf, costmap)
    cells = costmap.info.to_cells(points)
    cells = cells[((cells >= 0) & (cells < costmap.info.shape)).all(axis=1)]
    free = passable(parameters.allow_unknown)[costmap.data[cells[:, 0], cells[:, 1]]]
    if not free.any():
        raise NoValidControl("no point of the plan is free within the local costmap; plan again or recover")
    return cells[free][-1:]
