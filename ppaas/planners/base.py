"""Interface of global planners: the request, the result, and the abstract planner.

It is ``nav2_core::GlobalPlanner`` without the life cycle: a planner is constructed with its parameters and may then
plan many times, in one thread at a time.
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
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Point, Pose, Quaternion
from ppaas.messages.nav_msgs import Path
from ppaas.planners.path_json import path_message
from ppaas.planners.traits import Traits
from ppaas.plans.stored import Conditions, Origin
from ppaas.plugins import parameters_in_use


def never() -> bool:
    """Return false: the default cancel checker, which never cancels."""
    return False


@dataclass(frozen=True, slots=True)
class PlanRequest:
    """Request for a plan.

    Parameters
    ----------
    start, goal : Pose2D
        In the frame of the costmap [m, rad].
    tolerance : float
        If the goal is blocked, the planner may use the nearest free cell within this distance instead [m].
    timeout : float
        Time limit, counted from the call of ``plan`` [s].
    cancelled : callable
        Cancel checker, called at least every 10 ms while planning; true stops the planner.
    threads : int
        Maximum number of threads of the kernels.
    clock : callable
        Returns monotonic time [s].
    """

    start: Pose2D
    goal: Pose2D
    tolerance: float = 0.0
    timeout: float = float("inf")
    cancelled: Callable[[], bool] = never
    threads: int = 1
    clock: Clock = monotonic


class PlanResult(msgspec.Struct, frozen=True):
    """A path, with its cost and the effort of finding it.

    Parameters
    ----------
    cells : (n, 2) int32 array
        Row, column from start to goal; each cell is a neighbour of the one before.
    poses : (n, 7) float64 array
        x, y, z [m] and quaternion in the frame of the costmap. The first pose is the requested start, the last the
        requested goal (or the free cell nearest to it, within the tolerance).
    cost : float
        Sum of the weights of the moves, recomputed in float64: 50 + 0.8·cost per cell entered, times √2 on a diagonal.
    length : float
        Length along the poses [m].
    expanded : int
        Number of cells whose value was settled.
    seconds : float
        Planning time [s].
    planner : str
        Name of the planner.
    origin : {"computed", "reused", "stitched"}
        Whether the plan was computed, or made from a kept plan.
    reused : str
        Id of that kept plan.
    id : str
        Id in the path plan database (``ppaas.plans.reuse.processor``); empty if the plan is not kept.
    conditions : dict
        Conditions under which it was computed: the planner's parameters, and those that ``ppaas.plans.stored`` names.
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
        """Return ``nav_msgs/Path``. Its poses are already JSON, which the encoder copies unchanged."""
        return path_message(self.poses, stamp or Header(frame_id=self.frame_id))


def pose_message(row: list[float]) -> Pose:
    """Return the ``geometry_msgs/Pose`` of one row of an (n, 7) array of poses."""
    x, y, z, qx, qy, qz, qw = row
    return Pose(Point(x, y, z), Quaternion(x=qx, y=qy, z=qz, w=qw))


class Planner(ABC):
    """A global planner.

    A subclass sets ``name``, ``purpose`` (when to choose it) and ``traits`` (its capabilities), and is registered by an
    entry point in the group ``ppaas.planners``. Its parameters are keyword arguments of its constructor. It stores each
    as an attribute of the same name, or all of them as one record in ``parameters``.
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
        """Return a planner with the same parameters, for another thread."""
        return self.fresh()

    def fresh(self) -> Self:
        """Return a planner with the same parameters that has kept nothing of any map."""
        return type(self)(**parameters_in_use(self))
