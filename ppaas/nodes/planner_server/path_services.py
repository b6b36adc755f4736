"""Path services for robots and programs: ``nav_msgs/GetPlan``, ``ppaas_msgs/ComputePath`` and ``PathRequest``.

Some computed plans are compared with the cheapest, to evaluate planners.
"""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import msgspec

from ppaas import planners
from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidInput, InvalidPlanner, NotFound, PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.base.message import Message
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.nav_msgs import GetPlanResponse
from ppaas.messages.ppaas_msgs import ComputePathRequest, ComputePathResponse
from ppaas.nodes.base import Context, Job, Reply
from ppaas.nodes.message_checks import finite_pose
from ppaas.nodes.planner_server.planner_queue import PlannerQueue
from ppaas.nodes.planner_server.variants import NO_VARIANTS, Given, Variants, parameters_of
from ppaas.planners.base import Planner, PlanRequest, PlanResult
from ppaas.planners.path_json import rows_text
from ppaas.planners.registry import PLANNERS
from ppaas.planners.through_poses import plan_through
from ppaas.planners.traits import Optimal
from ppaas.plans.path_service import PathAnswer, PathRequest, RequestPose
from ppaas.plans.reuse.processor import PlanProcessor
from ppaas.thread_budget import Threads

MAX_TIMEOUT = 60.0
"""Largest time limit of a plan [s]."""

ToResponse = Callable[[PlanResult], Message]
Outcome = Message | PPaaSError


def get_plan_response(result: PlanResult) -> GetPlanResponse:
    """Return the response of ``nav_msgs/GetPlan``."""
    return GetPlanResponse(result.to_message())


def compute_path_response(result: PlanResult) -> ComputePathResponse:
    """Return the response of ``ppaas_msgs/ComputePath``."""
    return ComputePathResponse(
        rows_text(result.poses), result.cost, result.length, result.expanded, result.seconds, result.planner,
        result.id, result.origin, result.reused, str(msgspec.json.encode(result.conditions), "utf-8"),
    )  # fmt: skip


def path_answer(result: PlanResult) -> PathAnswer:
    """Return the answer to a program."""
    # Imported here: robots do not need its kernels.
    from ppaas.plans.encoding.codes import pack_poses  # noqa: PLC0415

    return PathAnswer(
        pack_poses(result.poses), result.cost, result.length, result.expanded, result.seconds, result.planner,
        result.id, result.origin, result.reused or None, msgspec.Raw(msgspec.json.encode(result.conditions)),
    )  # fmt: skip


class PathServices:
    """Plans with any installed planner, one request after the other.

    Parameters
    ----------
    context : Context
        Context of the node that offers the services.
    costmap : Costmap
        Costmap of the map alone.
    default : str
        Planner of requests that name none.
    threads : callable
        Returns the largest number of threads that kernels may use now.
    processor : PlanProcessor
        Finds stored plans.
    tuned : dict of str to Planner, optional
        Planners with their own parameters, by name; they must not be used by others.
    variants : Variants
        Makes planners and costmaps for requests with parameters.
    """

    def __init__(
        self,
        context: Context,
        costmap: Costmap,
        default: str,
        threads: Threads,
        *,
        processor: PlanProcessor,
        tuned: Mapping[str, Planner] | None = None,
        variants: Variants = NO_VARIANTS,
    ) -> None:
        self._context = context
        self._processor = processor
        self._comparison = PlanComparison(context, processor)
        self._costmap = costmap
        self._default = default
        self._threads = threads
        self._queue = PlannerQueue(context)
        self._planners = dict(tuned or {})
        self._variants = variants

    def use_map(self, costmap: Costmap, processor: PlanProcessor, variants: Variants | None = None) -> None:
        """Replace the map for requests from now on; planners forget what they have prepared of the last one."""
        self._costmap, self._processor = costmap, processor
        self._variants = variants or self._variants
        self._comparison = PlanComparison(self._context, processor)
        self._planners = {name: planner.fresh() for name, planner in self._planners.items()}

    def compute(self, request: ComputePathRequest, reply: Reply, costmap: Costmap | None = None) -> Job:
        """Handle a ``ppaas_msgs/ComputePath``; raises as ``plan`` does, and ``InvalidInput`` for an invalid pose."""
        start, goal = finite_pose(request.start, "the start"), finite_pose(request.goal, "the goal")
        return self.plan(
            start, goal, reply, compute_path_response, costmap=costmap, planner=request.planner,
            tolerance=request.tolerance, timeout=request.timeout, reuse=request.reuse,
            parameters=parameters_of(request.parameters),
        )  # fmt: skip

    def compute_packed(self, request: PathRequest, reply: Reply) -> Job:
        """Handle the request of a program; raises as ``compute`` does."""
        start, goal = _pose(request.start, "the start"), _pose(request.goal, "the goal")
        return self.plan(
            start, goal, reply, path_answer, planner=request.planner, tolerance=request.tolerance,
            timeout=request.timeout, reuse=request.reuse, parameters=request.parameters,
        )  # fmt: skip

    def plan(
        self, start: Pose2D, goal: Pose2D, reply: Reply, respond: ToResponse,
        *, planner: str = "", tolerance: float = 0.0, timeout: float = 5.0, costmap: Costmap | None = None,
        reuse: bool = True, parameters: Given | None = None, through: Sequence[Pose2D] = (),
    ) -> Job:  # fmt: skip
        """Plan, and reply with ``respond(result)`` or with the error.

        ``costmap`` replaces the costmap of the map alone; ``reuse`` allows a stored plan; ``parameters`` are parameters
        of the planner and the global costmap that differ from the usual ones; the path passes the poses ``through``.

        Returns
        -------
        Job
            Handle to cancel the request.

        Raises
        ------
        InvalidPlanner
            No planner of that name is installed.
        InvalidInput
            A tolerance, timeout or parameter is out of range.
        Unavailable
            Too many requests are waiting.
        """
        if not (math.isfinite(tolerance) and tolerance >= 0.0):
            raise InvalidInput(f"tolerance must be finite and at least 0 m, not {tolerance}")
        if not 0.0 < timeout <= MAX_TIMEOUT:
            raise InvalidInput(f"timeout must be above 0 and at most {MAX_TIMEOUT:g} s, not {timeout}")
        chosen, used = self._planner(planner or self._default, parameters), costmap or self._costmap
        # Those of the request, even if `use_map` replaces them while it waits in the queue.
        processor, comparison = self._processor, self._comparison
        planned: tuple[PlanRequest, PlanResult] | None = None

        def work(cancelled: Cancelled) -> Message:
            nonlocal planned
            request = PlanRequest(start, goal, tolerance, timeout, cancelled, self._threads())
            if parameters:
                variant = self._variants.variant(parameters)
                return respond(variant.processor.plan(chosen, variant.costmap, request, reuse=reuse))
            result = plan_through(lambda part: processor.plan(chosen, used, part, reuse=reuse), through, request)
            # A path through other poses cannot be compared with the cheapest one from start to goal.
            planned = None if through else (request, result)
            return respond(result)

        def done(result: Outcome) -> None:
            reply(result)
            if planned is not None:
                # After the reply, so that nobody waits for the second plan.
                comparison.see(chosen, used, *planned)

        return self._queue.submit(work, done)

    def _planner(self, name: str, parameters: Given | None = None) -> Planner:
        own = PLANNERS.own_name(name)
        try:
            if parameters:
                return self._variants.planner(own, parameters)
            if own not in self._planners:
                self._planners[own] = planners.create(own)
        except NotFound as error:
            raise InvalidPlanner(str(error)) from error
        return self._planners[own]


def _pose(numbers: RequestPose, what: str) -> Pose2D:
    return finite_pose(Pose.of(Pose2D(*numbers)), what)


# -- plan comparison: sampled plans are computed again by an optimal planner, to evaluate planners ---------------------

ONE_OF = 16
"""Sampling interval: of each planner's plans, the first of every `ONE_OF` is compared."""

COMPARISON_TIMEOUT = 5.0
"""Time limit of the second plan [s]."""


class PlanComparison:
    """Plans sampled requests again with an optimal planner, after the reply was sent.

    Parameters
    ----------
    context : Context
        Context of the node that plans.
    processor : PlanProcessor
        Receives the results.
    """

    def __init__(self, context: Context, processor: PlanProcessor) -> None:
        self._context = context
        self._processor = processor
        self._planner: Planner | None = None
        self._seen: Counter[str] = Counter()
        self._running = False

    def see(self, planner: Planner, costmap: Costmap, request: PlanRequest, result: PlanResult) -> None:
        """Compare a plan if it is sampled."""
        if result.origin != "computed" or planner.traits.optimal is Optimal.ALWAYS:
            return  # not a new plan, or already the cheapest
        self._seen[planner.name] += 1
        if self._running or self._seen[planner.name] % ONE_OF != 1:
            return
        self._running = True
        cheapest_of = self._planner = self._planner or planners.create("dijkstra")

        def work(cancelled: Callable[[], bool]) -> PlanResult:
            return cheapest_of.plan(costmap, replace(request, cancelled=cancelled, timeout=COMPARISON_TIMEOUT))

        def done(cheapest: PlanResult | PPaaSError) -> None:
            self._running = False
            if isinstance(cheapest, PlanResult):  # an error means a timeout, or a stricter check of the footprint
                self._processor.compared(planner, request, result.length, cheapest.length)

        self._context.start(work, done)


Cancelled = Callable[[], bool]
