"""Plans that are kept, as those see them who may drive them again."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

from ppaas.geometry import Pose2D, Poses

Origin = Literal["computed", "reused", "stitched"]

BARE_MAP = "bare_map"
"""Parameter of a kept plan: whether it was made on the map alone, without anything that a robot saw."""

ROBOT_RADIUS = "robot_radius"
"""Parameter of a kept plan: of the robot that it was made for [m]."""


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
    parameters : dict
        Of the planner, and `BARE_MAP` and `ROBOT_RADIUS`.
    """

    id: str
    version: str
    planner: str
    start: tuple[float, float, float]
    goal: tuple[float, float, float]
    length: float
    poses: Poses
    whole: bool = True
    parameters: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Question:
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

    def find(self, question: Question, within: float) -> Sequence[StoredPlan] | None:
        """Return plans worth a look, the best first; None if there is no answer within so many seconds."""
        ...


def same_planner(stored: StoredPlan, question: Question) -> bool:
    """Tell whether a plan was made by the planner that is asked, with the same parameters."""
    own = {name: value for name, value in stored.parameters.items() if name not in (BARE_MAP, ROBOT_RADIUS)}
    return stored.planner == question.planner and own == question.parameters


def same_robot(stored: StoredPlan, question: Question) -> bool:
    """Tell whether a plan was made for a robot of the same radius, so that its costs were the same."""
    radius = stored.parameters.get(ROBOT_RADIUS)
    return isinstance(radius, int | float) and math.isclose(radius, question.robot_radius, abs_tol=1e-9)
