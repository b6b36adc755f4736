"""Planners for robots that are longer than wide: by the disc around one, or by its outline where that is too wide.

Where the disc fits, a robot may turn, so such paths are preferred. A plan through narrow passages is made if there is
no such path, or if it is a detour. It counts if the outline fits along it.
"""

import dataclasses
import math
from collections.abc import Callable
from typing import Any, TypeVar

from msgspec.structs import replace

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.narrow_passages import fits_along, with_narrow_passages
from ppaas.errors import GoalOccupied, NoValidPath, PlanCancelled, PlanningError, StartOccupied
from ppaas.footprints import Footprint
from ppaas.parameters import FOOTPRINT
from ppaas.planners.base import Planner, PlanRequest, PlanResult
from ppaas.planners.grid.astar import AStar
from ppaas.planners.registry import PLANNERS
from ppaas.plugins import parameters_in_use
from ppaas.robot_model.known_models import RobotModel

P = TypeVar("P", bound=Planner)

Plan = Callable[[Costmap, PlanRequest], PlanResult]

BLOCKED = (NoValidPath, GoalOccupied, StartOccupied)
"""Errors that the disc around the robot may have caused."""

DETOUR, FARTHER = 1.25, 2.0
"""A path may be a detour if it is longer than this part of the straight line, and by this distance [m]."""

SHORTER = 0.8
"""Largest part of a detour that a path through narrow passages may take: the robot cannot turn there."""


@dataclasses.dataclass(frozen=True, slots=True)
class Outline:
    """Outline of a robot.

    Parameters
    ----------
    footprint : Footprint
        Its corners.
    inner_radius : float
        Radius of the largest disc around the robot's origin within it [m].
    """

    footprint: Footprint
    inner_radius: float

    def plan(self, usual: Plan, narrow: Plan, costmap: Costmap, request: PlanRequest) -> PlanResult:
        """Plan by ``usual``, and by ``narrow`` through narrow passages if that is needed; raises as ``usual`` does."""
        began = request.clock()
        try:
            wide = usual(costmap, request)
        except BLOCKED:
            found = self._through_narrow(narrow, costmap, request, began)
            if found is None:
                raise
            return found
        if not _may_be_shorter(wide, costmap, request):
            return wide
        found = self._through_narrow(narrow, costmap, request, began)
        return wide if found is None or found.length > SHORTER * wide.length else found

    def _through_narrow(self, narrow: Plan, costmap: Costmap, request: PlanRequest, began: float) -> PlanResult | None:
        """Return a path through narrow passages along which the outline fits, found in the time left, or None."""
        left = began + request.timeout - request.clock()
        if left <= 0.0:
            return None
        passages = with_narrow_passages(costmap, self.inner_radius, request.threads)
        try:
            found = narrow(passages, dataclasses.replace(request, timeout=left))
        except PlanCancelled:
            raise
        except PlanningError:
            return None
        fits = fits_along(costmap, found.poses, self.footprint)
        return replace(found, seconds=request.clock() - began) if fits else None


def by_outline(planner: P, outline: Outline) -> P:
    """Return a planner with the same name and parameters that also plans through narrow passages.

    A planner that prepares maps keeps the disc's map; narrow passages are then planned by `AStar`. So does one that
    replans: a twin of it plans narrow passages.
    """
    kind = type(planner)
    parameters: dict[str, Any] = parameters_in_use(planner)

    def other() -> Planner:
        unknown = bool(parameters.get("allow_unknown", True))
        return AStar(allow_unknown=unknown) if kind.traits.indexed else planner.twin()

    class ByOutline(kind):  # type: ignore[misc, valid-type]  # a class, so that its twins plan by the outline too
        """The planner, for an outline."""

        _narrow: Planner | None = None

        def plan(self, costmap: Costmap, request: PlanRequest) -> PlanResult:
            """Find a path; raises as the planner does."""
            found = outline.plan(super().plan, self._plan_narrow, costmap, request)
            return found if found.planner == kind.name else replace(found, planner=kind.name)

        def _plan_narrow(self, costmap: Costmap, request: PlanRequest) -> PlanResult:
            if not (kind.traits.indexed or kind.traits.incremental):
                found: PlanResult = super().plan(costmap, request)
                return found
            if self._narrow is None:
                self._narrow = other()
            return self._narrow.plan(costmap, request)

    made: P = ByOutline(**parameters)
    return made


def _may_be_shorter(result: PlanResult, costmap: Costmap, request: PlanRequest) -> bool:
    """Return whether a path may be a detour, or begins by leaving a narrow passage."""
    cell = costmap.info.cell_of(request.start.x, request.start.y)
    straight = math.hypot(request.goal.x - request.start.x, request.goal.y - request.start.y)
    leaves = cell is not None and int(costmap.data[cell]) == INSCRIBED_INFLATED_OBSTACLE
    return leaves or result.length > max(DETOUR * straight, straight + FARTHER)


def planner_of(body: RobotModel, name: str, parameters: dict[str, Any]) -> Planner:
    """Return a planner; if it uses a footprint, that is the body's unless the parameters contain another.

    For a body that is longer than wide, it also plans through passages in which the body cannot turn.

    Raises
    ------
    NotFound
        There is no planner of that name; the text lists those that exist.
    InvalidParameter
        A parameter is unknown or invalid.
    """
    planner = PLANNERS.create(name, parameters)
    if body.footprint and FOOTPRINT not in parameters and FOOTPRINT in parameters_in_use(planner):
        planner = PLANNERS.create(name, {**parameters, FOOTPRINT: body.footprint})
    if body.inner_radius is not None and FOOTPRINT not in parameters:
        planner = by_outline(planner, Outline(body.footprint, body.inner_radius))
    return planner
