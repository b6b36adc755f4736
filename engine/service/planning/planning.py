"""Path planning for programs, in planning containers: one for each user, map version and set of labels, while used."""

import logging
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any

import msgspec
from msgspec import Raw

from engine.service.links.place_link import PlaceLink
from engine.service.planning.fleet_requests import FleetAnswer, FleetRequest
from engine.service.planning.path_requests import CostAnswer, CostRequest, PathAnswer, PathRequest, RequestPose
from engine.service.planning.pose_unpacker import PoseUnpacker
from engine.specs.containers import MapVersion
from engine.specs.start_state import KERNEL_PATIENCE, READY, StartState, explained
from ppaas.errors import Queued, Starting, Unavailable
from ppaas.geometry import Pose2D
from ppaas.messages import decode, encode
from ppaas.messages.base.message import Message
from ppaas.messages.fleet.fleet_plans import ComputeFleetPlanRequest, ComputeFleetPlanResponse
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.paths.packed_paths import ComputePackedPathRequest, ComputePackedPathResponse
from ppaas.messages.ppaas_msgs import (
    ComputeCostsRequest,
    ComputeCostsResponse,
)
from ppaas.plans.stored import ORIGINS

logger = logging.getLogger(__name__)

READY_TIMEOUT = 15.0
"""Time within which a planning container must be ready [s]."""

ANSWER_MARGIN = 5.0
"""Time that a container may take in addition to the planner's time limit, and to waiting for kernels [s]."""


_Where = tuple[str, MapVersion, dict[str, str]]

Use = Callable[[str, MapVersion, dict[str, str], bool], Awaitable[tuple[PlaceLink, int | None]]]
"""Opens the place of a planning container for a user, a map version and labels, or uses it. The last argument is
whether it may wait in the queue. Returns the link of the place, and the position in the queue."""


@dataclass(frozen=True, slots=True)
class _Asked:
    answer: bytes
    container: str
    pid: int


class Planning:
    """Computes paths and costs without a robot.

    Parameters
    ----------
    use : callable
        Opens the place of a planning container, or uses it; returns its link and its position in the queue, if any.
    start_of : callable
        Returns whether containers can start, and the kernels that machines compile.
    """

    def __init__(self, use: Use, start_of: Callable[[], StartState] = lambda: READY) -> None:
        self._use = use
        self._start_of = start_of
        self._unpacker = PoseUnpacker()

    async def compute_path(self, user: str, version: MapVersion, request: PathRequest) -> PathAnswer:
        """Plan in the user's planning container for this map version.

        Raises
        ------
        PlanningError
            There is no path; raised as one of its subclasses.
        QuotaExceeded
            The user's quota allows no other container.
        Queued
            The request waits in the queue.
        Starting
            Kernels that the request needs are being compiled, and it may not wait in the queue.
        Unavailable
            No machine has room, or the container was lost.
        """
        self._unpacker.begin()
        start, goal = ([*Pose2D(*pose)] for pose in (request.start, request.goal))
        question = ComputePackedPathRequest(
            start, goal, request.planner, request.tolerance, request.timeout, request.reuse, _json(request.parameters)
        )
        where = user, version, request.labels
        asked = await self._ask(where, "compute_packed_path", question, request.timeout, queue=request.queue)
        response = decode(ComputePackedPathResponse, asked.answer)
        return PathAnswer(
            poses=await self._unpacker.unpack(response.poses),
            cost=response.cost,
            length=response.length,
            expanded=response.expanded,
            seconds=response.seconds,
            planner=response.planner,
            plan_id=response.plan_id,
            origin=ORIGINS[response.origin],
            reused=response.reused or None,
            conditions=Raw(response.conditions),
            container=asked.container,
            pid=asked.pid,
            map=version.id,
            version=version.version,
        )

    async def compute_costs(self, user: str, version: MapVersion, request: CostRequest) -> CostAnswer:
        """Compute the costs from each start to each goal in the user's planning container for this map version.

        Raises
        ------
        InvalidInput
            There are too many starts or goals.
        PlanningError, QuotaExceeded, Unavailable
            As ``compute_path`` raises them.
        """
        starts, goals = ([Pose.of(Pose2D(*pose)) for pose in ends] for ends in (request.starts, request.goals))
        question = ComputeCostsRequest(starts, goals, request.timeout, _json(request.parameters))
        asked = await self._ask((user, version, request.labels), "compute_costs", question, request.timeout)
        response = decode(ComputeCostsResponse, asked.answer)
        costs = Raw(response.costs)
        return CostAnswer(costs, response.seconds, asked.container, asked.pid, version.id, version.version)

    async def plan_fleet(self, user: str, version: MapVersion, request: FleetRequest) -> FleetAnswer:
        """Plan for a fleet in the user's planning container for this map version.

        Raises
        ------
        InvalidInput
            There are too many robots or cells, a number is out of range, or two robots share a cell.
        PlanningError, QuotaExceeded, Unavailable
            As ``compute_path`` raises them.
        """
        question = ComputeFleetPlanRequest(
            _flat(request.starts), _flat(request.goals), request.radius, request.margin, request.speed,
            request.seconds, request.seed, request.timeout, request.turn_seconds, list(request.speeds or ()),
        )  # fmt: skip
        asked = await self._ask((user, version, request.labels), "compute_fleet_plan", question, request.timeout)
        found = decode(ComputeFleetPlanResponse, asked.answer)
        return FleetAnswer(
            Raw(found.paths), Raw(found.times), found.spacing, found.step_seconds, found.cost, found.bound,
            found.makespan, found.turns, found.seconds, asked.container, asked.pid, version.id, version.version,
        )  # fmt: skip

    async def _ask(
        self, where: _Where, service: str, question: Message, timeout: float, *, queue: bool = False
    ) -> "_Asked":
        try:
            return await self._asked(where, service, question, timeout, queue)
        except Starting as error:
            if not queue:
                raise
            raise Queued(1, str(error).partition(";")[0]) from error

    async def _asked(self, where: _Where, service: str, question: Message, timeout: float, queue: bool) -> "_Asked":
        with explained(self._start_of):
            place, position = await self._use(*where, queue)
        if position is not None:
            if not queue:
                raise Unavailable(f"its container is at position {position} of the queue: set 'queue' to wait for it")
            start = self._start_of()
            raise Queued(position, "" if start.ready else start.text)
        await place.ready(READY_TIMEOUT, lambda: self._start_of().refusal())
        # The container is noted before the call, since it may be lost or replaced by the time of the answer.
        container, pid = place.container, place.pid
        answer = await place.call(service, encode(question), KERNEL_PATIENCE + timeout + ANSWER_MARGIN)
        if container is None or pid is None:
            raise Unavailable("the container was lost; send the request again")
        return _Asked(answer, container, pid)


def _flat(poses: tuple[RequestPose, ...]) -> list[float]:
    """Return x, y of poses, one after the other."""
    return [number for pose in poses for number in pose[:2]]


def _json(parameters: dict[str, Any]) -> str:
    return msgspec.json.encode(parameters).decode() if parameters else ""
