"""Planner of a robot in traffic: its plan is the way that it is granted."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from ppaas.errors import GoalOccupied
from ppaas.geometry import Pose2D, Poses, poses_along
from ppaas.nodes.granted_move_base.traffic_link import TrafficLink
from ppaas.nodes.move_base.robot_planner import NoPlan, Planned, RobotPlanner, Waiting
from ppaas.planners.base import PlanResult
from ppaas.traffic.leg_path import STEP, path_along
from ppaas.traffic.room_in_cells import Point

NAME = "traffic"
"""Name of the planner in plans."""


class GrantedPlanner(RobotPlanner):
    """Plans as any robot's planner while the robot drives freely, and else returns the granted way.

    Parameters
    ----------
    link : TrafficLink
    options
        As of `RobotPlanner`.
    """

    def __init__(self, link: TrafficLink, *arguments: object, **options: object) -> None:
        super().__init__(*arguments, **options)  # type: ignore[arg-type]
        self._link = link

    def is_blocked(self, poses: Poses) -> bool:
        """Return whether a plan is blocked now; a granted way is as it is."""
        return self._link.way.free and super().is_blocked(poses)

    def request(
        self, start: Pose2D, goal: Pose2D, done: Callable[[Planned], None], through: Sequence[Pose2D] = ()
    ) -> None:
        """Plan to a goal, or pass on the granted way; ``done`` is called with the result."""
        self._link.path_is_final = False
        if self._link.way.free and not self._link.must_stop:
            super().request(start, goal, done, through)
        else:
            done(self._granted(start, goal))

    def _granted(self, start: Pose2D, goal: Pose2D) -> Planned:
        link, way = self._link, self._link.way
        if reason := link.refusal:
            return NoPlan(GoalOccupied(f"the traffic of the map refuses the goal: {reason}"), final=True)
        if link.must_stop or not way.spacing:
            return Waiting(link.waits_for())
        leg, ends = way.leg()
        final = self._final_pose(goal) if ends else None
        if final is None and (not link.has_to_move or len(leg) < 2):
            return Waiting(link.waits_for())
        poses = path_along(leg, way.spacing, start, final)
        link.path_is_final = final is not None
        length = float(np.hypot(*np.diff(poses[:, :2], axis=0).T).sum())
        return PlanResult(np.empty((0, 2), np.int32), poses, 0.0, length, 0, 0.0, NAME)

    def _final_pose(self, goal: Pose2D) -> Pose2D | None:
        """Return where the robot stops at its goal; None on the way there."""
        way = self._link.way
        return way.stop_at(goal, self._is_free) if way.leads_to(self._link.goal_id) else None

    def _is_free(self, begin: Point, end: Point) -> bool:
        """Return whether the robot sees nothing on a straight way."""
        steps = max(math.ceil(math.dist(begin, end) / STEP), 1)
        return not super().is_blocked(poses_along(np.linspace(begin, end, steps + 1)))
