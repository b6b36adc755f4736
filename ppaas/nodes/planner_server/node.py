"""Node ``planner_server``: plans paths on a map, without a robot."""

from collections.abc import Callable
from typing import ClassVar

from ppaas.costmap.costmap import Costmap
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.base.message import Message
from ppaas.messages.fleet.fleet_plans import ComputeFleetPlan, ComputeFleetPlanRequest
from ppaas.messages.geometry_msgs import PoseStamped
from ppaas.messages.nav_msgs import GetPlan, GetPlanRequest
from ppaas.messages.ppaas_msgs import ComputeCosts, ComputeCostsRequest, ComputePath, ComputePathRequest
from ppaas.nodes.base import Context, Node, Reply, Service
from ppaas.nodes.frames import MAP
from ppaas.nodes.message_checks import finite_pose
from ppaas.nodes.planner_server.cost_service import CostService
from ppaas.nodes.planner_server.fleet_service import FleetService
from ppaas.nodes.planner_server.path_services import PathServices, get_plan_response
from ppaas.nodes.planner_server.variants import Variants
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
