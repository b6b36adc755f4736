"""Planners in space: their interface, which adds heights and layers to the one in the plane, and their registry."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

from ppaas.clock import Clock, monotonic
from ppaas.costmap.voxels import VoxelCostmap
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.planners.base import PlanRequest, PlanResult, never
from ppaas.plugins import PluginRegistry


class Pose3D(NamedTuple):
    """Pose of an upright robot in space: x, y, z of its base [m], theta about z [rad]."""

    x: float
    y: float
    z: float
    theta: float = 0.0


@dataclass(frozen=True, slots=True)
class PlanRequest3D:
    """Request for a plan in space.

    Parameters
    ----------
    start, goal : Pose3D
        In the frame of the costmap [m, rad].
    tolerance : float
        If the start or the goal is blocked, the planner may use the nearest free voxel within this distance [m].
    timeout, cancelled, threads, clock
        As in ``PlanRequest``.
    """

    start: Pose3D
    goal: Pose3D
    tolerance: float = 0.0
    timeout: float = float("inf")
    cancelled: Callable[[], bool] = never
    threads: int = 1
    clock: Clock = monotonic

    def from_above(self) -> PlanRequest:
        """Return the same request in the plane, without heights.

        Raises
        ------
        InvalidInput
            A height that is not finite.
        """
        for what, pose in (("start", self.start), ("goal", self.goal)):
            if not math.isfinite(pose.z):
                raise InvalidInput(f"the {what} must be finite x, y, z [m] and theta [rad], not {tuple(pose)}")
        start, goal = (Pose2D(pose.x, pose.y, pose.theta) for pose in (self.start, self.goal))
        return PlanRequest(start, goal, self.tolerance, self.timeout, self.cancelled, self.threads, self.clock)


class VolumePlanner(ABC):
    """A global planner in space.

    A subclass sets ``name`` and ``purpose`` (when to choose it), takes its parameters as keyword arguments of its
    constructor, and is registered by an entry point in the group ``ppaas.planners3d``.
    """

    name: ClassVar[str]
    purpose: ClassVar[str]

    @abstractmethod
    def plan(self, costmap: VoxelCostmap, request: PlanRequest3D) -> PlanResult:
        """Find a path; the ``cells`` of the result are (n, 3): layer, row, column.

        Raises
        ------
        PlanningError
            One of its subclasses, with the code of Nav2's ``ComputePathToPose``.
        """


# -- registry ----------------------------------------------------------------------------------------------------------

VOLUME_PLANNERS: PluginRegistry[VolumePlanner] = PluginRegistry(
    "ppaas.planners3d",
    "planner in space",
    VolumePlanner,  # type: ignore[type-abstract]
    aliases={},
)


def create(name: str, **parameters: Any) -> VolumePlanner:
    """Create a planner in space by its name.

    Raises
    ------
    NotFound
        No planner of that name is installed.
    InvalidParameter
        The planner has no such parameter, or the value is invalid.
    """
    return VOLUME_PLANNERS.create(name, parameters)


def planner_names() -> tuple[str, ...]:
    """Return the names of all installed planners in space."""
    return VOLUME_PLANNERS.names()
