"""Path planning for programs, in planning containers: one for each user, map version and set of labels, while used."""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any

import msgspec
from msgspec import Raw

from engine.control.planning.requests import CostAnswer, CostRequest, FleetAnswer, FleetRequest
from engine.links.place_link import PlaceLink
from engine.specs.containers import MapVersion
from engine.specs.start_state import KERNEL_PATIENCE, READY, StartState, explained
from ppaas.errors import Queued, Starting, Unavailable
from ppaas.geometry import Pose2D, Poses
from ppaas.messages import decode, encode
from ppaas.messages.base.message import Message
from ppaas.messages.fleet.fleet_plans import ComputeFleetPlanRequest, ComputeFleetPlanResponse
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.ppaas_msgs import ComputeCostsRequest, ComputeCostsResponse
from ppaas.plans.path_service import PathAnswer, PathRequest, RequestPose

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

    async def compute_path(self, user: str, version: MapVersion, request: PathRequest) -> tuple[PathAnswer, Poses]:
        """Plan in the user's planning container for this map version; return the answer, and its poses unpacked.

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
        # Before the container is asked for, so that both start at the same time.
        self._unpacker.begin()
        where = user, version, request.labels
        asked = await self._ask(where, "compute_packed_path", request, request.timeout, queue=request.queue)
        answer = decode(PathAnswer, asked.answer)
        answer.container, answer.pid, answer.map, answer.version = (
            asked.container,
            asked.pid,
            version.id,
            version.version,
        )
        return answer, await self._unpacker.unpack(answer.poses)

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
    return [number for pose in poses for number in pose[:2]]


def _json(parameters: dict[str, Any]) -> str:
    return msgspec.json.encode(parameters).decode() if parameters else ""


# -- poses of paths, whose kernels are loaded at the first one ---------------------------------------------------------

Unpack = Callable[[bytes], Poses]


class PoseUnpacker:
    """Loads the kernels in a thread, since numba takes a third of a second, while the first container starts."""

    def __init__(self) -> None:
        self._unpack: Unpack | None = None
        self._loading: asyncio.Future[Unpack] | None = None

    def begin(self) -> None:
        """Begin to load the kernels, unless they are loaded."""
        if self._unpack is None and self._loading is None:
            self._loading = asyncio.get_running_loop().run_in_executor(None, _load)
            self._loading.add_done_callback(self._loaded)

    async def unpack(self, packed: bytes) -> Poses:
        """Return (n, 7) poses; wait for the kernels if need be.

        Raises
        ------
        MalformedMessage
            The bytes are not packed poses.
        """
        if self._unpack is None:
            self.begin()
            assert self._loading is not None
            # Shielded: a caller that gives up must not end the loading for the others.
            return (await asyncio.shield(self._loading))(packed)
        return self._unpack(packed)

    def _loaded(self, loading: asyncio.Future[Unpack]) -> None:
        if not loading.cancelled() and loading.exception() is None:
            self._unpack = loading.result()
        self._loading = None


def _load() -> Unpack:
    from ppaas.planners.kernels import pose_text  # noqa: PLC0415 - imports numba; see above
    from ppaas.plans.encoding import codes  # noqa: PLC0415
    from ppaas.plans.encoding.kernels import chain_code  # noqa: PLC0415

    chain_code.warm()
    pose_text.warm()
    return codes.unpack_poses
