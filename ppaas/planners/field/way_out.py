"""Plans of a robot that is in a keep-out zone: out of it by the shortest way, and then as for any other robot."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.errors import NoValidPath, StartOccupied
from ppaas.geometry import Pose2D, yaw_of
from ppaas.planners.base import PlanRequest, PlanResult
from ppaas.planners.ends import cause_text, escape
from ppaas.planners.field.cost_field import CostField
from ppaas.planners.path import path_cost, path_length, path_poses
from ppaas.planners.through_poses import joined
from ppaas.planners.watch import Watch
from ppaas.planners.weights import passable

OUT = "way_out"
"""Name of the planner of the way out."""


def plan_way_out(
    plan: Callable[[PlanRequest], PlanResult], costmap: Costmap, leaving: Costmap, request: PlanRequest
) -> PlanResult:
    """Plan out of a keep-out zone, and from there to the goal.

    Parameters
    ----------
    plan : callable
        Plans from the place where the robot has left the zone to the goal.
    costmap : Costmap
        By which robots are planned that are in no zone: the zone is lethal.
    leaving : Costmap
        The same map, on which the zone is expensive.
    request : PlanRequest

    Raises
    ------
    StartOccupied
        No way leads out of the zone.
    PlanningError
        As ``plan`` raises it.
    """
    watch = Watch(request)
    opens = passable(allow_unknown=False)
    cell = costmap.info.cell_of(request.start.x, request.start.y)
    if cell is None or opens[costmap.data[cell]]:
        return plan(request)
    exits = _rim(opens[costmap.data]) & opens[leaving.data]
    try:
        return _planned(plan, _way_out(costmap, leaving, request, exits, watch), request)
    except NoValidPath:
        exits &= _led_to(costmap, request, watch)
        if not exits.any():
            raise
    # The nearest side is cut off from the goal, as where a zone is across a corridor.
    return _planned(plan, _way_out(costmap, leaving, request, exits, watch), request)


def _planned(plan: Callable[[PlanRequest], PlanResult], out: PlanResult | None, request: PlanRequest) -> PlanResult:
    if out is None:
        return plan(request)
    x, y, _, *quaternion = out.poses[-1].tolist()
    left = max(request.timeout - out.seconds, 0.0)
    return joined([out, plan(replace(request, start=Pose2D(x, y, yaw_of(*quaternion)), timeout=left))])


def _led_to(costmap: Costmap, request: PlanRequest, watch: Watch) -> NDArray[np.bool_]:
    """Return the cells from which there is a path to the goal; none if the goal is blocked."""
    cell = costmap.info.cell_of(request.goal.x, request.goal.y)
    if cell is None or not passable(allow_unknown=True)[costmap.data[cell]]:
        return np.zeros(costmap.info.shape, np.bool_)
    field = CostField(costmap, np.array([cell]), threads=request.threads, check=watch.check)
    field.grow()
    return np.isfinite(field.values())


def _way_out(
    costmap: Costmap, leaving: Costmap, request: PlanRequest, exits: NDArray[np.bool_], watch: Watch
) -> PlanResult | None:
    """Return the path to the nearest of some cells; None if something else than the zone bars the robot's cell."""
    opens = passable(allow_unknown=False)
    start = costmap.info.cell_of(request.start.x, request.start.y)
    assert start is not None
    begin = escape(leaving, start, opens, watch.check)  # from a wall beside which the robot stands in the zone
    if not len(begin) or not exits.any():
        return None
    row, column = begin[-1].tolist()
    field = CostField(leaving, np.argwhere(exits), allow_unknown=False, threads=request.threads, check=watch.check)
    if not field.grow((row, column)):
        what = cause_text(costmap, request.start, "a keep-out zone")
        text = f"no way leads out of {what} from x={request.start.x:.3f} y={request.start.y:.3f}"
        raise StartOccupied(f"{text}; drive the robot out by hand, or change the zones of the map")
    cells = np.concatenate((begin[:-1], field.path_from((row, column))))
    x, y = costmap.info.to_world(cells[-1]).tolist()
    end = Pose2D(x, y, float(np.arctan2(y - request.start.y, x - request.start.x)))
    poses = path_poses(costmap, cells, request.start, end, threads=request.threads)
    return PlanResult(
        cells=cells,
        poses=poses,
        cost=path_cost(costmap, cells),
        length=path_length(poses),
        expanded=field.settled,
        seconds=watch.seconds(),
        planner=OUT,
    )


def _rim(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the cells beside others that are not among them."""
    inner = cells.copy()
    inner[1:] &= cells[:-1]
    inner[:-1] &= cells[1:]
    inner[:, 1:] &= cells[:, :-1]
    inner[:, :-1] &= cells[:, 1:]
    rim: NDArray[np.bool_] = cells & ~inner
    return rim
