"""What a global planner is given and what it gives.

The interface is that of ``nav2_core::GlobalPlanner`` without its life cycle: a planner is made with its parameters
and may be asked many times, one thread at a time.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Self

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.clock import Clock, monotonic
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D, Poses
from ppaas.messages.geometry_msgs import Point, Pose, Quaternion
from ppaas.messages.nav_msgs import Path
from ppaas.messages.std_msgs import Header
from ppaas.planners.path_json import path_message
from ppaas.planners.traits import Traits
from ppaas.plans.stored import Conditions, Origin
from ppaas.plugins import parameters_in_use


def never() -> bool:
    """Be the cancel checker that never cancels."""
    return False


@dataclass(frozen=True, slots=True)
class PlanRequest:
    """What to plan.

    Parameters
    ----------
    start, goal : Pose2D
        In the frame of the costmap [m, rad].
    tolerance : float
        If the goal is blocked, the free cell nearest to it within this distance will do [m].
    timeout : float
        Time allowed from the call of ``plan`` [s].
    cancelled : callable
        Asked often while planning (at least every 10 ms); true stops it.
    threads : int
        Most threads that kernels may use.
    clock : callable
        Seconds, monotonic.
    """

    start: Pose2D
    goal: Pose2D
    tolerance: float = 0.0
    timeout: float = float("inf")
    cancelled: Callable[[], bool] = never
    threads: int = 1
    clock: Clock = monotonic


class PlanResult(msgspec.Struct, frozen=True):
    """A path, and what it took to find it.

    Parameters
    ----------
    cells : (n, 2) int32 array
        Row, column from start to goal, each a neighbour of the one before.
    poses : (n, 7) float64 array
        The same in the frame of the costmap; the first is the start and the last the goal as they were asked for
        (or the free cell nearest to the goal, under a tolerance).
    cost : float
        Sum of the weights of the moves, recounted in float64: 50 + 0.8·cost a cell entered, times √2 on a diagonal.
    length : float
        Along the poses [m].
    expanded : int
        Cells whose value was settled.
    seconds : float
        Time taken.
    planner : str
        Who planned it.
    origin : {"computed", "reused", "stitched"}
        Whether it was computed, or made of a plan that was kept.
    reused : str
        Id of that plan.
    id : str
        By which it is kept (``ppaas.plans.reuse.plan_ids``); none where nobody keeps it.
    conditions : dict
        Under which it was made: the parameters of the planner, and what ``ppaas.plans.stored`` names.
    """

    cells: NDArray[np.int32]
    poses: Poses
    cost: float
    length: float
    expanded: int
    seconds: float
    planner: str
    frame_id: str = "map"
    origin: Origin = "computed"
    reused: str = ""
    id: str = ""
    conditions: Conditions = msgspec.field(default_factory=dict)

    def to_message(self, stamp: Header | None = None) -> Path:
        """Return ``nav_msgs/Path``; its poses are JSON already, which the encoder copies as it is."""
        return path_message(self.poses, stamp or Header(frame_id=self.frame_id))


def pose_message(row: list[float]) -> Pose:
    """Return ``geometry_msgs/Pose`` of one row of an (n, 7) array."""
    x, y, z, qx, qy, qz, qw = row
    return Pose(Point(x, y, z), Quaternion(x=qx, y=qy, z=qz, w=qw))


class Planner(ABC):
    """A global planner.

    A subclass names itself in ``name``, tells in ``purpose`` what it is for and in ``traits`` what it can do, and is
    found by an entry point in the group ``ppaas.planners``. It takes its parameters as keyword arguments of its
    constructor and keeps them as attributes of the same names, or all of them as a record in ``parameters``.
    """

    name: ClassVar[str]
    purpose: ClassVar[str]
    traits: ClassVar[Traits] = Traits()

    @abstractmethod
    def plan(self, costmap: Costmap, request: PlanRequest) -> PlanResult:
        """Find a path.

        Raises
        ------
        PlanningError
            One of its subclasses, with the code of Nav2's ``ComputePathToPose``.
        """

    def twin(self) -> Self:
        """Return one with the same parameters, for another thread."""
        return type(self)(**parameters_in_use(self))
