"""Paths that a robot's clients ask for, around what the robot sees, which the robot does not follow."""

import contextlib
from collections.abc import Mapping

from ppaas.costmap.costmap import Costmap
from ppaas.errors import TransformError
from ppaas.messages.base.message import Message
from ppaas.messages.nav_msgs import GetPlanRequest
from ppaas.messages.ppaas_msgs import ComputePathRequest
from ppaas.nodes.base import Context, Reply
from ppaas.nodes.frames import MAP
from ppaas.nodes.message_checks import expect, pose_in
from ppaas.nodes.move_base.path_actions import PathActions
from ppaas.nodes.move_base.surroundings import Surroundings
from ppaas.nodes.planner_server.path_services import PathServices, get_plan_response
from ppaas.planners.base import Planner
from ppaas.plans.reuse.processor import PlanProcessor
from ppaas.thread_budget import Threads


class RobotPaths:
    """Serves Move Base's path services, and owns the actions that compute paths.

    Parameters
    ----------
    context : Context
        Context of the node that serves them.
    surroundings : Surroundings
        Pose, frames and observed obstacles of the robot.
    default : str
        Planner of requests that name none.
    threads : callable
        Returns the largest number of threads that kernels may use now.
    processor : PlanProcessor
        Finds stored plans.
    tuned : dict of str to Planner
        Planners with their own parameters, by name; they must not be used by others.

    Attributes
    ----------
    actions : PathActions
    services : PathServices
    """

    def __init__(
        self,
        context: Context,
        surroundings: Surroundings,
        default: str,
        threads: Threads,
        *,
        processor: PlanProcessor,
        tuned: Mapping[str, Planner],
    ) -> None:
        self._context = context
        self._surroundings = surroundings
        self.services = PathServices(context, surroundings.static, default, threads, processor=processor, tuned=tuned)
        self.actions = PathActions(context, self.services, surroundings, self._seen)

    def call(self, request: Message, reply: Reply) -> None:
        """Plan a path for a call of ``make_plan`` or ``compute_path``.

        Raises
        ------
        InvalidInput
            A pose is not finite, or has no frame.
        TransformError
            A frame or the robot's own pose is unknown.
        """
        if isinstance(request, ComputePathRequest):
            self.services.compute(request, reply, self._seen())
        else:
            self._make_plan(expect(request, GetPlanRequest), reply)

    def _make_plan(self, question: GetPlanRequest, reply: Reply) -> None:
        """Plan around observed obstacles as for a goal, without following the plan; an active goal continues."""
        around = self._surroundings
        goal = pose_in(around.frames.tree, MAP, question.goal, "the goal")
        # As in move_base, a start without a frame is the robot's pose.
        here = not question.start.header.frame_id
        now = self._context.elapsed()
        start = around.pose(now) if here else pose_in(around.frames.tree, MAP, question.start, "the start")
        self.services.plan(start, goal, reply, get_plan_response, tolerance=question.tolerance, costmap=self._seen())

    def _seen(self) -> Costmap:
        """Return the costmap of the map with the obstacles that the robot sees now."""
        around, now = self._surroundings, self._context.elapsed()
        with contextlib.suppress(TransformError):  # without a pose, new scans cannot be used
            around.look_around(around.pose(now), now)
        return around.seen()
