"""Paths through several poses, planned from each pose to the next."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ppaas.errors import PlanningError, PlanTimeout
from ppaas.geometry import Pose2D
from ppaas.planners.base import PlanRequest, PlanResult


def plan_through(
    plan: Callable[[PlanRequest], PlanResult], through: Sequence[Pose2D], request: PlanRequest
) -> PlanResult:
    """Plan from the start through poses to the goal.

    Parameters
    ----------
    plan : callable
        Plans one part of the path.
    through : sequence of Pose2D
        Poses before the goal, in the order in which they are passed.
    request : PlanRequest
        Start, goal and the time limit of all parts together.

    Raises
    ------
    PlanningError
        One of its subclasses; if there are several poses, the text says to which of them there is no path.
    """
    if not through:
        return plan(request)
    began = request.clock()
    poses = (*through, request.goal)
    parts: list[PlanResult] = []
    for number, (start, goal) in enumerate(zip((request.start, *through), poses, strict=True), 1):
        left = request.timeout - (request.clock() - began)
        try:
            if left <= 0.0:
                raise PlanTimeout(f"no path within {request.timeout:g} s")
            parts.append(plan(replace(request, start=start, goal=goal, timeout=left)))
        except PlanningError as error:
            raise type(error)(f"pose {number} of {len(poses)}: {error}") from error
    return joined(parts)


def joined(parts: Sequence[PlanResult]) -> PlanResult:
    """Return the parts of a path as one plan, which is not a stored one itself."""
    first, rest = parts[0], parts[1:]
    computed = [part for part in parts if part.origin == "computed"]
    return PlanResult(
        cells=np.concatenate([first.cells, *(part.cells[1:] for part in rest)]),
        poses=np.concatenate([first.poses, *(part.poses[1:] for part in rest)]),
        cost=sum(part.cost for part in parts),
        length=sum(part.length for part in parts),
        expanded=sum(part.expanded for part in parts),
        seconds=sum(part.seconds for part in parts),
        planner=first.planner,
        frame_id=first.frame_id,
        origin=(computed or parts)[0].origin,
        conditions=first.conditions,
    )
