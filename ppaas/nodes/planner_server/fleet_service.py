"""Service ``ppaas_msgs/ComputeFleetPlan``: paths of many robots that keep out of each other's way."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.bounded import BoundedDict
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidInput, PlanTimeout
from ppaas.messages.fleet.fleet_plans import ComputeFleetPlanRequest, ComputeFleetPlanResponse
from ppaas.nodes.base import Context, Job, Reply
from ppaas.nodes.planner_server.path_services import MAX_TIMEOUT
from ppaas.nodes.planner_server.planner_queue import PlannerQueue
from ppaas.planners.base import PlanRequest
from ppaas.planners.watch import Watch
from ppaas.zones.zone import Zone

if TYPE_CHECKING:
    from ppaas.fleet.metric_roadmap import MetricFloor, MetricRoadmap
    from ppaas.fleet.plan import FleetPlan
    from ppaas.fleet.problem import FleetProblem

MAX_ROBOTS = 2_000
"""Largest number of robots in a request."""

MAX_SECONDS = 10.0
"""Longest time of improvement [s]."""

LEAST_SPEED = 1e-3
"""Least speed of robots [m/s]."""

MAX_TURN = 1000.0
"""Longest time of a quarter turn [s]."""

MAX_PLACES = 1_000_000
"""Largest number of robots times steps in a response, some 25 MB of text."""

MAX_SCHEDULE = 50_000_000
"""Largest number of cells times steps of a plan that is improved: 8 bytes each, 12 if robots take time to turn."""

MOST_FLOORS = 2
"""Number of roadmaps that are kept, the last used ones."""

DECIMALS = 3
"""Decimals of x and y in metres, and of times in seconds."""


class FleetService:
    """Plans for fleets, one request after the other.

    Parameters
    ----------
    context : Context
        Context of the node that offers the service.
    layers : MapLayers
        The map, and its zones.
    """

    def __init__(self, context: Context, layers: MapLayers) -> None:
        self._layers = layers
        self._queue = PlannerQueue(context)
        self._floors: BoundedDict[tuple[float, float, tuple[str, ...]], MetricFloor] = BoundedDict(MOST_FLOORS)
        self._context = context

    def compute(self, request: ComputeFleetPlanRequest, reply: Reply) -> Job:
        """Plan for a fleet, and reply with the plan or with the error.

        Returns
        -------
        Job
            Handle to cancel the request.

        Raises
        ------
        InvalidInput
            A place is invalid, there are too many, or another number is out of range.
        Unavailable
            Too many requests are waiting.
        """
        _check_numbers(request)
        starts, goals = _places(request.starts, "start"), _places(request.goals, "goal")
        speeds = _speeds(request, len(starts))
        zones = self._layers.zones.in_force(self._context.now())

        def work(cancelled: Callable[[], bool]) -> ComputeFleetPlanResponse:
            origin = self._layers.grid.info.origin
            watch = Watch(PlanRequest(origin, origin, timeout=request.timeout, cancelled=cancelled))
            floor = self._floor(request.radius, request.margin, zones, watch.check)
            problem = floor.problem(starts, goals, watch.check)
            plan = _plan(problem, request, _turn(floor.metric, speeds, request), watch)
            return _response(floor.metric, plan, speeds, request, watch)

        return self._queue.submit(work, reply)

    def _floor(self, radius: float, margin: float, zones: Sequence[Zone], check: Callable[[], None]) -> "MetricFloor":
        # Imported by the first request: few containers need the modules.
        from ppaas.fleet.cell_rules import rules_on  # noqa: PLC0415 - see above
        from ppaas.fleet.lane_roadmap import roadmap_on  # noqa: PLC0415 - see above
        from ppaas.fleet.metric_roadmap import MetricFloor  # noqa: PLC0415 - see above
        from ppaas.fleet.robot_sizes import RobotSizes, clearance_of  # noqa: PLC0415 - see above

        key = radius, margin, tuple(zone.name for zone in zones)
        found = self._floors.get(key)
        if found is None:
            to_lethal, info = clearance_of(self._layers), self._layers.grid.info
            metric = roadmap_on(to_lethal, info, zones, RobotSizes(radius, margin), check)
            metric = replace(metric, roadmap=rules_on(metric, zones, radius).roadmap)
            found = MetricFloor(to_lethal, info, metric, radius, self._layers.costmap.causes)
        # Also one that was found: the last used ones are kept.
        self._floors[key] = found
        return found


def _turn(metric: "MetricRoadmap", speeds: NDArray[np.float64], request: ComputeFleetPlanRequest) -> float:
    """Return the cost of a quarter turn in moves of mean time; 0 on lanes, whose directions the improvement ignores."""
    if not metric.IS_GRID or not len(speeds):
        return 0.0
    return request.turn_seconds / float((metric.spacing / speeds).mean())


def _plan(problem: "FleetProblem", request: ComputeFleetPlanRequest, turn: float, watch: Watch) -> "FleetPlan":
    """Return the first plan, improved for the time that the request allows; a quarter turn costs so many steps."""
    from ppaas.fleet.first_plan import first_plan  # noqa: PLC0415 - its kernels are not for every container
    from ppaas.fleet.improvement import improved  # noqa: PLC0415 - see above

    plan = first_plan(problem, request.seed, watch.check)
    if len(problem) * len(plan.steps) > MAX_PLACES:
        raise InvalidInput(
            f"a plan of {len(problem)} robots and {len(plan.steps)} steps is too long for an answer: their product may "
            f"be {MAX_PLACES}; plan for fewer robots, or nearer goals"
        )
    if request.seconds == 0.0 or len(plan.steps) * len(problem.roadmap) > MAX_SCHEDULE:
        return plan
    began = watch.seconds()

    def passed() -> float:
        try:
            watch.check()
        except PlanTimeout:
            return 1.0
        return (watch.seconds() - began) / request.seconds

    return improved(problem, plan, request.seed, turn, passed).plan()


def _response(
    metric: "MetricRoadmap",
    plan: "FleetPlan",
    speeds: NDArray[np.float64],
    request: ComputeFleetPlanRequest,
    watch: Watch,
) -> ComputeFleetPlanResponse:
    """Return the answer for robots of these speeds, (n,) float64 [m/s]."""
    from ppaas.fleet.plan import timing_of  # noqa: PLC0415 - its kernels are not for every container

    times, turned = timing_of(metric.roadmap, plan, 1.0 / speeds, request.turn_seconds, metric.centres)
    return ComputeFleetPlanResponse(
        paths=_text(metric, plan),
        times=msgspec.json.encode(times.T.round(DECIMALS).tolist()).decode(),
        spacing=metric.spacing,
        step_seconds=metric.longest_move / min(request.speeds, default=request.speed),
        cost=plan.cost,
        bound=plan.bound,
        makespan=plan.makespan,
        turns=round(float(turned.sum())),
        seconds=watch.seconds(),
    )


def _check_numbers(request: ComputeFleetPlanRequest) -> None:
    if not 0.0 < request.timeout <= MAX_TIMEOUT:
        raise InvalidInput(f"timeout must be above 0 and at most {MAX_TIMEOUT:g} s, not {request.timeout}")
    if not 0.0 <= request.seconds <= MAX_SECONDS:
        raise InvalidInput(f"seconds of improvement must be from 0 to {MAX_SECONDS:g}, not {request.seconds}")
    if not (math.isfinite(request.speed) and request.speed >= LEAST_SPEED):
        raise InvalidInput(f"speed must be finite and at least {LEAST_SPEED:g} m/s, not {request.speed}")
    if not 0.0 <= request.turn_seconds <= MAX_TURN:
        raise InvalidInput(f"turn_seconds must be from 0 to {MAX_TURN:g}, not {request.turn_seconds}")
    if request.seed < 0:
        raise InvalidInput(f"seed must be at least 0, not {request.seed}")


def _speeds(request: ComputeFleetPlanRequest, robots: int) -> NDArray[np.float64]:
    """Return the speed of each robot, (n,) float64 [m/s]; raise ``InvalidInput`` if one is out of range."""
    if not request.speeds:
        return np.full(robots, request.speed)
    if len(request.speeds) != robots:
        raise InvalidInput(f"there are {len(request.speeds)} speeds and {robots} starts; give one speed a robot")
    speeds = np.array(request.speeds, dtype=np.float64)
    for robot in np.nonzero(~(np.isfinite(speeds) & (speeds >= LEAST_SPEED)))[0][:1]:
        raise InvalidInput(
            f"the speed of robot {robot} must be finite and at least {LEAST_SPEED:g} m/s, not {speeds[robot]:g}"
        )
    return speeds


def _places(numbers: list[float], what: str) -> NDArray[np.float64]:
    """Return x, y of each robot, (n, 2) float64 [m]; raise ``InvalidInput`` if they are no such list."""
    if len(numbers) % 2:
        raise InvalidInput(f"{what}s must have x and y for each robot, not {len(numbers)} numbers")
    places = np.array(numbers, dtype=np.float64).reshape(-1, 2)
    if len(places) > MAX_ROBOTS:
        raise InvalidInput(f"a request may have at most {MAX_ROBOTS} {what}s, not {len(places)}")
    for robot in np.nonzero(~np.isfinite(places).all(axis=1))[0][:1]:
        raise InvalidInput(f"the {what} of robot {robot} must be finite x, y in metres")
    return places


def _text(metric: "MetricRoadmap", plan: "FleetPlan") -> str:
    """Return the paths as JSON; the text of each cell is made once."""
    centres = metric.centres.round(DECIMALS)
    texts = {cell: f"[{centres[cell, 0]},{centres[cell, 1]}]" for cell in np.unique(plan.steps).tolist()}
    paths = [",".join([texts[cell] for cell in path.tolist()]) for path in plan.steps.T]
    return f"[{','.join([f'[{path}]' for path in paths])}]"
