"""Node ``planner_server``: plans paths and computes costs on a map, without a robot."""

import math
from collections.abc import Callable
from typing import ClassVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.base.message import Message
from ppaas.messages.fleet.fleet_plans import ComputeFleetPlan, ComputeFleetPlanRequest
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.nav_msgs import GetPlan, GetPlanRequest
from ppaas.messages.ppaas_msgs import (
    ComputeCosts,
    ComputeCostsRequest,
    ComputeCostsResponse,
    ComputePath,
    ComputePathRequest,
)
from ppaas.nodes.base import Context, Job, Node, Reply, Service
from ppaas.nodes.frames import MAP
from ppaas.nodes.message_checks import finite_pose
from ppaas.nodes.planner_server.fleet_service import FleetService
from ppaas.nodes.planner_server.path_services import MAX_TIMEOUT, PathServices, get_plan_response
from ppaas.nodes.planner_server.planner_queue import PlannerQueue
from ppaas.nodes.planner_server.variants import Variants, parameters_of
from ppaas.planners.base import PlanRequest
from ppaas.planners.watch import Watch
from ppaas.plans.path_service import ComputePackedPath, PathRequest
from ppaas.plans.reuse.processor import PlanProcessor
from ppaas.thread_budget import Threads


class PlannerServerNode(Node):
    """Answers ``make_plan`` (``nav_msgs/GetPlan``), ``compute_path``, ``compute_costs`` and ``compute_fleet_plan``.

    It answers ``compute_packed_path`` as ``compute_path``, with poses as bytes: for processes that answer programs.

    Poses are in the map frame. If there is no path, the reply is the planning error.

    Parameters
    ----------
    context : Context
        The node's context.
    base_global_planner : str
        Planner of requests that name none.
    threads : callable
        Returns the largest number of threads that kernels may use now.
    surroundings_of : callable
        Takes the layers of a map; returns its costmap, the processor that finds stored plans, and the maker of planners
        and costmaps for requests with parameters.
    layers : MapLayers
        The map.
    """

    name: ClassVar[str] = "planner_server"
    services: ClassVar[tuple[Service, ...]] = (
        Service("make_plan", GetPlan),
        Service("compute_path", ComputePath),
        Service("compute_packed_path", ComputePackedPath),
        Service("compute_costs", ComputeCosts),
        Service("compute_fleet_plan", ComputeFleetPlan),
    )

    def __init__(
        self,
        context: Context,
        base_global_planner: str,
        threads: Threads,
        *,
        surroundings_of: Callable[[MapLayers], tuple[Costmap, PlanProcessor, Variants]],
        layers: MapLayers,
    ) -> None:
        super().__init__(context)
        self._surroundings_of, self._threads = surroundings_of, threads
        costmap, processor, variants = surroundings_of(layers)
        self._paths = PathServices(
            context, costmap, base_global_planner, threads, processor=processor, variants=variants
        )
        self._costs = CostService(context, variants, threads)
        self._fleets = FleetService(context, layers)

    def use_layers(self, layers: MapLayers) -> None:
        """Plan on other layers of the map, because other zones are closed."""
        costmap, processor, variants = self._surroundings_of(layers)
        self._paths.use_map(costmap, processor, variants)
        self._costs = CostService(self.context, variants, self._threads)
        self._fleets = FleetService(self.context, layers)

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Start planning a path or for a fleet, or computing costs.

        Raises
        ------
        InvalidInput
            A pose is not finite or not in the map frame, or a tolerance, timeout or parameter is out of range.
        InvalidPlanner
            No planner of that name is installed.
        Unavailable
            Too many requests are waiting.
        """
        if isinstance(request, PathRequest):
            self._paths.compute_packed(request, reply)
        elif isinstance(request, ComputePathRequest):
            self._paths.compute(request, reply)
        elif isinstance(request, ComputeCostsRequest):
            self._costs.compute(request, reply)
        elif isinstance(request, ComputeFleetPlanRequest):
            self._fleets.compute(request, reply)
        elif isinstance(request, GetPlanRequest):
            start, goal = _in_map(request.start, "the start"), _in_map(request.goal, "the goal")
            self._paths.plan(start, goal, reply, get_plan_response, tolerance=request.tolerance)
        else:
            raise InvalidInput(f"service {service!r} does not accept {type(request).__name__}")


def _in_map(stamped: PoseStamped, what: str) -> Pose2D:
    frame = stamped.header.frame_id.lstrip("/")
    if frame not in ("", MAP):
        raise InvalidInput(f"{what} must be in frame {MAP!r}, not {frame!r}: without a robot there are no other frames")
    return finite_pose(stamped.pose, what)


# -- costs of the cheapest paths from each start to each goal: ``ppaas_msgs/ComputeCosts`` -----------------------------

MAX_ENDS = 1_000
"""Largest number of starts, and of goals, in a request."""

MAX_COSTS = 50_000
"""Largest number of costs in a response, less than 1 MiB of text."""

DECIMALS = 3
"""Decimals of a cost."""


class CostService:
    """Computes the costs of paths from each start to each goal, one request after the other.

    Parameters
    ----------
    context : Context
        Context of the node that offers the service.
    variants : Variants
        Costmaps of the map by parameters.
    threads : callable
        Returns the largest number of threads that kernels may use now.
    """

    def __init__(self, context: Context, variants: Variants, threads: Threads) -> None:
        self._variants = variants
        self._threads = threads
        self._queue = PlannerQueue(context)

    def compute(self, request: ComputeCostsRequest, reply: Reply) -> Job:
        """Compute costs, and reply with them or with the error.

        Returns
        -------
        Job
            Handle to cancel the request.

        Raises
        ------
        InvalidInput
            A pose is invalid, there are too many, or the timeout or a parameter is out of range.
        Unavailable
            Too many requests are waiting.
        """
        if not 0.0 < request.timeout <= MAX_TIMEOUT:
            raise InvalidInput(f"timeout must be above 0 and at most {MAX_TIMEOUT:g} s, not {request.timeout}")
        starts, goals = _places(request.starts, "start"), _places(request.goals, "goal")
        if len(starts) * len(goals) > MAX_COSTS:
            raise InvalidInput(f"a request may ask for at most {MAX_COSTS} costs, not {len(starts)}×{len(goals)}")

        parameters = parameters_of(request.parameters)
        unknown = self._variants.allows_unknown(parameters)

        def work(cancelled: Callable[[], bool]) -> ComputeCostsResponse:
            from ppaas.planners.batch.cost_matrix import cost_matrix  # noqa: PLC0415 - its kernels are not for every container

            costmap = self._variants.variant(parameters).costmap
            origin = costmap.info.origin
            watch = Watch(PlanRequest(origin, origin, timeout=request.timeout, cancelled=cancelled))
            lengths = self._variants.lengths(parameters, self._threads(), watch.check)
            if lengths is not None:
                ends = [[lengths.cell(x, y) for x, y in places.tolist()] for places in (starts, goals)]
                return ComputeCostsResponse(_text(lengths.between(ends[0], ends[1], watch.check)), watch.seconds())
            costs = cost_matrix(
                costmap, starts, goals, threads=self._threads(), check=watch.check, allow_unknown=unknown
            )
            return ComputeCostsResponse(_text(costs), watch.seconds())

        return self._queue.submit(work, reply)


def _places(poses: list[Pose], what: str) -> NDArray[np.float64]:
    if len(poses) > MAX_ENDS:
        raise InvalidInput(f"a request may have at most {MAX_ENDS} {what}s, not {len(poses)}")
    places = [finite_pose(pose, f"{what} {number}")[:2] for number, pose in enumerate(poses)]
    return np.array(places, dtype=np.float64).reshape(-1, 2)


def _text(costs: NDArray[np.float64]) -> str:
    rows = [[cost if math.isfinite(cost) else None for cost in row] for row in costs.round(DECIMALS).tolist()]
    return msgspec.json.encode(rows).decode()
