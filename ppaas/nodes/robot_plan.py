"""Planning for a robot that moves: around what it sees, and telling errors that will pass from those that will not."""

from dataclasses import dataclass

from ppaas.costmap.costmap import Costmap
from ppaas.errors import (
    GoalOccupied,
    GoalOutsideMap,
    InvalidInput,
    InvalidPlanner,
    NoValidPath,
    PlanningError,
    PPaaSError,
    StartOutsideMap,
)
from ppaas.planners.base import Planner, PlanRequest, PlanResult

FINAL = (GoalOutsideMap, StartOutsideMap, InvalidPlanner, InvalidInput)
"""Errors that neither clearing obstacles nor turning on the spot can change."""

BLOCKED = (GoalOccupied, NoValidPath)
"""Errors that an obstacle may be the cause of: final if they hold on the bare map too."""


@dataclass(frozen=True, slots=True)
class NoPlan:
    """Why there is no plan, and whether that is final."""

    error: PPaaSError
    final: bool


def plan_for_robot(planner: Planner, static: Costmap, current: Costmap, request: PlanRequest) -> PlanResult | NoPlan:
    """Plan around the obstacles seen; if they block the way, ask the bare map whether it is theirs to block.

    Parameters
    ----------
    planner : Planner
        Asked once, or twice if the way is blocked.
    static, current : Costmap
        The map alone, and with what the robot has seen; the same object if it has seen nothing new.
    """
    try:
        return planner.plan(current, request)
    except BLOCKED as error:
        return NoPlan(error, final=current is static or _is_blocked(planner, static, request))
    except FINAL as error:
        return NoPlan(error, final=True)
    except PlanningError as error:
        return NoPlan(error, final=False)


def _is_blocked(planner: Planner, static: Costmap, request: PlanRequest) -> bool:
    try:
        planner.plan(static, request)
    except BLOCKED:
        return True
    except PlanningError:
        return False
    return False
