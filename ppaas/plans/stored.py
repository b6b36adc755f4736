"""Plans that are kept, as those see them who may drive them again."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol, get_args

from ppaas.geometry import Pose2D, Poses

Origin = Literal["computed", "reused", "stitched"]
ORIGINS: Mapping[str, Origin] = {origin: origin for origin in get_args(Origin)}

LARGEST_TOLERANCE = 0.5
"""Farthest that the end of a plan may be from where it is sought [m]: 81 buckets of
``ppaas.plans.encoding.end_buckets``, or up to 256."""

Conditions = dict[str, Any]
"""Under which a plan was made: the parameters of its planner, what its robot keeps out of, which counts as such, too,
`BARE_MAP` and `ROBOT_RADIUS`."""

BARE_MAP = "bare_map"
"""Whether a plan is what a planner made of the map alone, without anything that a robot saw."""

ROBOT_RADIUS = "robot_radius"
"""Of the robot that a plan was made for [m]."""


@dataclass(frozen=True, slots=True)
class StoredPlan:
    """A plan that was kept, or the stretch of it that is offered.

    Parameters
    ----------
    id : str
        Of the whole plan.
    version : str
        Of the map that it was made on.
    planner : str
        Who made it, by the own name.
    start, goal : tuple of float
        x, y [m], yaw [rad] of the ends of the whole plan.
    length : float
        Of the whole plan [m].
    poses : (n, 7) float64 array
        Of the stretch; none where only the head is at hand.
    whole : bool
        Whether the stretch is all of it.
    conditions : dict
        Under which it was made.
    given : bool
        Whether a program gave it. Who made it under which conditions is then what that program says, and nothing
        follows from it.
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
    """Which plan is looked for.

    Parameters
    ----------
    start, goal : Pose2D
        In the frame of the map.
    version : str
        Of the map.
    planner : str
        Who would compute it.
    parameters : dict
        Of that planner.
    robot_radius : float
        [m].
    tolerance : float
        How far from the ends of a kept plan those asked for may lie [m].
    kinematic : bool
        Whether that planner heeds how the robot can turn.
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
    """Where kept plans are looked for. It is asked by threads that plan."""

    def may_wait(self) -> bool:
        """Tell whether the thread that asks may wait for an answer."""
        ...

    def find(self, question: PlanQuery, within: float) -> Sequence[StoredPlan] | None:
        """Return plans worth a look, the best first; None if there is no answer within so many seconds."""
        ...


class EmptyLibrary:
    """A library of nothing, for homes that keep no plans."""

    def may_wait(self) -> bool:
        """Let anybody wait: the answer is here."""
        return True

    def find(self, question: PlanQuery, within: float) -> Sequence[StoredPlan]:
        """Return none."""
        return ()


def own_parameters(conditions: Conditions) -> dict[str, Any]:
    """Return those conditions that are parameters of the planner."""
    return {name: value for name, value in conditions.items() if name not in (BARE_MAP, ROBOT_RADIUS)}


def same_planner(stored: StoredPlan, question: PlanQuery) -> bool:
    """Tell whether a plan was made by the planner that is asked, with the same parameters, and not just given."""
    same = stored.planner == question.planner and own_parameters(stored.conditions) == question.parameters
    return same and not stored.given


def same_robot(stored: StoredPlan, question: PlanQuery) -> bool:
    """Tell whether a plan was made for a robot of the same radius, so that its costs were the same."""
    radius = stored.conditions.get(ROBOT_RADIUS)
    return isinstance(radius, int | float) and math.isclose(radius, question.robot_radius, abs_tol=1e-9)
