"""Stored plans, as the code that may reuse them sees them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

from ppaas.geometry import Pose2D, Poses

Origin = Literal["computed", "reused", "stitched"]

LARGEST_TOLERANCE = 0.5
"""Largest distance between an end of a stored plan and the requested end [m]. A search then reads 81 buckets of
``ppaas.plans.encoding.end_buckets``, or up to 256."""

Conditions = dict[str, Any]
"""Conditions under which a plan was made: the parameters of the planner, the masks that the robot obeys, `BARE_MAP` and
`ROBOT_RADIUS`."""

BARE_MAP = "bare_map"
"""Condition: whether the planner used the map alone, without anything that a robot had seen."""

ROBOT_RADIUS = "robot_radius"
"""Condition: radius of the robot for which the plan was made [m]."""


@dataclass(frozen=True, slots=True)
class StoredPlan:
    """A stored plan, or the part of it that a search returned.

    Parameters
    ----------
    id : str
        Id of the whole plan.
    version : str
        Version of the map on which it was made.
    planner : str
        Name of the planner that made it.
    start, goal : tuple of float
        x, y [m], yaw [rad] of the ends of the whole plan.
    length : float
        Length of the whole plan [m].
    poses : (n, 7) float64 array
        Poses of the part; empty if only the head of the plan was read.
    whole : bool
        Whether the part is the whole plan.
    conditions : dict
        Conditions under which it was made.
    given : bool
        Whether a program supplied the plan. Its planner and conditions are then that program's claim, and nothing may
        be concluded from them.
    """

    id: str
    version: str
    planner: str
    start: tuple[float, float, float]
    goal: tuple[float, float, float]
    length: float
    poses: Poses
    whole: bool = True
    conditions: Conditions = field(default_factory=dict)
    given: bool = False


@dataclass(frozen=True, slots=True)
class PlanQuery:
    """A search for a stored plan.

    Parameters
    ----------
    start, goal : Pose2D
        Requested ends, in the frame of the map.
    version : str
        Version of the map.
    planner : str
        Planner that would otherwise compute the plan.
    parameters : dict
        Parameters of that planner.
    robot_radius : float
        Radius of the robot [m].
    tolerance : float
        Largest distance between the ends of a stored plan and the requested ones [m].
    kinematic : bool
        Whether that planner respects how the robot can turn.
    """

    start: Pose2D
    goal: Pose2D
    version: str
    planner: str
    parameters: dict[str, Any]
    robot_radius: float
    tolerance: float
    kinematic: bool = False


class PlanLibrary(Protocol):
    """Source of stored plans. Planning threads call it."""

    def may_wait(self) -> bool:
        """Return whether the calling thread may wait for an answer."""
        ...

    def find(self, query: PlanQuery, within: float) -> Sequence[StoredPlan] | None:
        """Return candidate plans, the best first; None if there is no answer within ``within`` seconds."""
        ...


class EmptyLibrary:
    """A library without plans, for executors that do not store any."""

    def may_wait(self) -> bool:
        """Return True: the answer is always at hand."""
        return True

    def find(self, query: PlanQuery, within: float) -> Sequence[StoredPlan]:
        """Return an empty sequence."""
        return ()


def own_parameters(conditions: Conditions) -> dict[str, Any]:
    """Return the conditions that are parameters of the planner."""
    return {name: value for name, value in conditions.items() if name not in (BARE_MAP, ROBOT_RADIUS)}


def same_planner(stored: StoredPlan, query: PlanQuery) -> bool:
    """Return whether the requested planner made a plan with the same parameters.

    It is False for a plan that a program supplied.
    """
    same = stored.planner == query.planner and own_parameters(stored.conditions) == query.parameters
    return same and not stored.given


def same_robot(stored: StoredPlan, query: PlanQuery) -> bool:
    """Return whether a plan was made for a robot of the same radius, for which the map has the same costs."""
    radius = stored.conditions.get(ROBOT_RADIUS)
    return isinstance(radius, int | float) and math.isclose(radius, query.robot_radius, abs_tol=1e-9)
