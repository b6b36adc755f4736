"""Paths for programs: containers that only plan, one a user and map version, there while they are used."""

import asyncio
import logging
from dataclasses import dataclass

from msgspec import Raw

from engine.master.places import PlaceRequest
from engine.processes.background import Background
from engine.service.master_driver import CloudService
from engine.service.path_requests import CostAnswer, CostRequest, PathAnswer, PathRequest
from engine.specs.containers import MapVersion
from ppaas.errors import Queued, Unavailable
from ppaas.geometry import Pose2D
from ppaas.messages import decode, encode
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.message import Message
from ppaas.messages.ppaas_msgs import (
    ComputeCostsRequest,
    ComputeCostsResponse,
    ComputePathRequest,
    ComputePathResponse,
)
from ppaas.plans.stored import ORIGINS

logger = logging.getLogger(__name__)

IDLE = 120.0
"""Seconds after its last path that a planning container is kept."""

CORES = 1.0
READY_TIMEOUT = 15.0
PATIENCE = 10.0
"""Seconds after which whoever does not ask again leaves the queue."""

ANSWER_MARGIN = 5.0
"""Seconds that a container may take beyond the time that the planner is given."""


@dataclass(frozen=True, slots=True)
class _Asked:
    answer: bytes
    container: str
    pid: int


class Planning:
    """Computes paths without a robot."""

    def __init__(self, service: CloudService, idle: float = IDLE) -> None:
        self._service = service
        self._idle = idle
        self._used: dict[str, float] = {}
        self._closing: dict[str, asyncio.TimerHandle] = {}
        self._leaving: dict[str, asyncio.TimerHandle] = {}
        self._background = Background()

    async def compute_path(self, user: str, version: MapVersion, request: PathRequest) -> PathAnswer:
        """Plan in the user's planning container for this map version.

        Raises
        ------
        PlanningError
            There is no path; one of its subclasses.
        QuotaExceeded
            The user may not have another container.
        Unavailable
            No machine has room, or the container was lost.
        """
        start, goal = (Pose.of(Pose2D(*pose)) for pose in (request.start, request.goal))
        question = ComputePathRequest(start, goal, request.planner, request.tolerance, request.timeout, request.reuse)
        where = _place(user, version, request)
        asked = await self._ask(where, "compute_path", question, request.timeout, queue=request.queue)
        response = decode(ComputePathResponse, asked.answer)
        return PathAnswer(
            poses=Raw(response.poses),
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
        """Have the user's planning container for this map version tell what it costs from each start to each goal.

        Raises
        ------
        InvalidInput
            Too many starts or goals.
        PlanningError, QuotaExceeded, Unavailable
            As ``compute_path``.
        """
        starts, goals = ([Pose.of(Pose2D(*pose)) for pose in ends] for ends in (request.starts, request.goals))
        question = ComputeCostsRequest(starts, goals, request.timeout)
        asked = await self._ask(_place(user, version, request), "compute_costs", question, request.timeout)
        response = decode(ComputeCostsResponse, asked.answer)
        costs = Raw(response.costs)
        return CostAnswer(costs, response.seconds, asked.container, asked.pid, version.id, version.version)

    async def _ask(
        self, where: PlaceRequest, service: str, question: Message, timeout: float, *, queue: bool = False
    ) -> "_Asked":
        place = self._service.open_place(where, queue=queue)
        self._note_use(place.key)
        if (position := self._service.position(place.key)) is not None:
            if not queue:
                raise Unavailable(f"a container for this is asked for, at position {position} of the queue: wait, too")
            self._keep_in_queue(place.key)
            raise Queued(position)
        await place.ready(READY_TIMEOUT)
        # Who plans is asked before the call: the container may be gone, or another, when the answer is here.
        container, pid = place.container, place.pid
        answer = await place.call(service, encode(question), timeout + ANSWER_MARGIN)
        self._note_use(place.key)
        if container is None or pid is None:
            raise Unavailable("the container was lost; ask again")
        return _Asked(answer, container, pid)

    def _keep_in_queue(self, key: str) -> None:
        loop = asyncio.get_running_loop()
        if key in self._leaving:
            self._leaving[key].cancel()
        self._leaving[key] = loop.call_later(PATIENCE, self._leave_queue, key)

    def _leave_queue(self, key: str) -> None:
        del self._leaving[key]
        if self._service.position(key) is not None:
            self._background.run(self._service.close_place(key, Unavailable("nobody asked for it any more")))

    def _note_use(self, key: str) -> None:
        now = self._used[key] = asyncio.get_running_loop().time()
        if key not in self._closing:
            self._close_later(key, now + self._idle)

    def _close_later(self, key: str, at: float) -> None:
        self._closing[key] = asyncio.get_running_loop().call_at(at, self._close, key)

    def _close(self, key: str) -> None:
        del self._closing[key]
        unused_at = self._used[key] + self._idle
        if unused_at > asyncio.get_running_loop().time():
            self._close_later(key, unused_at)
            return
        del self._used[key]
        self._background.run(self._service.close_place(key, Unavailable("it was not used")))

    def close(self) -> None:
        """Forget what was to be closed later."""
        for handle in (*self._closing.values(), *self._leaving.values()):
            handle.cancel()


def _place(user: str, version: MapVersion, request: PathRequest | CostRequest) -> PlaceRequest:
    return PlaceRequest(user, version, CORES, labels=request.labels)
