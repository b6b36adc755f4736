"""Path planning for programs, in planning containers: one for each user, map version and set of labels, while used."""

import asyncio
import logging
from dataclasses import dataclass
from typing import Any

import msgspec
from msgspec import Raw

from engine.master.places import PlaceRequest
from engine.processes.background import Background
from engine.service.master_driver import MasterDriver
from engine.service.path_requests import CostAnswer, CostRequest, PathAnswer, PathRequest
from engine.specs.containers import MapVersion
from ppaas.errors import Queued, Unavailable
from ppaas.geometry import Pose2D
from ppaas.messages import decode, encode
from ppaas.messages.base.message import Message
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.ppaas_msgs import (
    ComputeCostsRequest,
    ComputeCostsResponse,
    ComputePathRequest,
    ComputePathResponse,
)
from ppaas.plans.stored import ORIGINS

logger = logging.getLogger(__name__)

IDLE = 120.0
"""Time after its last request for which a planning container is kept [s]."""

CORES = 1.0
"""Size of a planning container [cores]."""

READY_TIMEOUT = 15.0
"""Time within which a planning container must be ready [s]."""

PATIENCE = 10.0
"""Time after which a queued request that is not repeated leaves the queue [s]."""

ANSWER_MARGIN = 5.0
"""Time that a container may take in addition to the planner's time limit [s]."""


@dataclass(frozen=True, slots=True)
class _Asked:
    answer: bytes
    container: str
    pid: int


class Planning:
    """Computes paths and costs without a robot.

    Parameters
    ----------
    service : MasterDriver
        Opens the places of planning containers.
    idle : float
        Time after its last request for which a planning container is kept [s].
    """

    def __init__(self, service: MasterDriver, idle: float = IDLE) -> None:
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
            There is no path; raised as one of its subclasses.
        QuotaExceeded
            The user's quota allows no other container.
        Queued
            The request waits in the queue.
        Unavailable
            No machine has room, or the container was lost.
        """
        start, goal = (Pose.of(Pose2D(*pose)) for pose in (request.start, request.goal))
        question = ComputePathRequest(
            start, goal, request.planner, request.tolerance, request.timeout, request.reuse, _json(request.parameters)
        )
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
                raise Unavailable(f"its container is at position {position} of the queue: set 'queue' to wait for it")
            self._keep_in_queue(place.key)
            raise Queued(position)
        await place.ready(READY_TIMEOUT)
        # The container is noted before the call, since it may be lost or replaced by the time of the answer.
        container, pid = place.container, place.pid
        answer = await place.call(service, encode(question), timeout + ANSWER_MARGIN)
        self._note_use(place.key)
        if container is None or pid is None:
            raise Unavailable("the container was lost; send the request again")
        return _Asked(answer, container, pid)

    def _keep_in_queue(self, key: str) -> None:
        loop = asyncio.get_running_loop()
        if key in self._leaving:
            self._leaving[key].cancel()
        self._leaving[key] = loop.call_later(PATIENCE, self._leave_queue, key)

    def _leave_queue(self, key: str) -> None:
        del self._leaving[key]
        if self._service.position(key) is not None:
            self._background.run(self._service.close_place(key, Unavailable("its request was not repeated in time")))

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
        self._background.run(self._service.close_place(key, Unavailable("the planning container was idle")))

    def close(self) -> None:
        """Cancel all timers."""
        for handle in (*self._closing.values(), *self._leaving.values()):
            handle.cancel()


def _json(parameters: dict[str, Any]) -> str:
    return msgspec.json.encode(parameters).decode() if parameters else ""


def _place(user: str, version: MapVersion, request: PathRequest | CostRequest) -> PlaceRequest:
    return PlaceRequest(user, version, CORES, labels=request.labels)
