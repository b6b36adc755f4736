"""Bridge between tasks of the cloud and workcells of Open-RMF: tasks come by REST, workcells speak in the graph."""

import asyncio
import logging
from collections.abc import Collection, Mapping
from functools import partial
from typing import Final

from ppaas.clock import Clock, epoch
from ppaas.errors import Conflict, PPaaSError
from ppaas.wire.rmf.workcells import KINDS, Kind, Workcells
from ppaas.wire.ros.graph import Qos
from ppaas.wire.ros.rmf_workcells import DISPENSER_REQUEST, DISPENSER_RESULT, INGESTOR_REQUEST, INGESTOR_RESULT
from robots.bridges.core.notices import Notices
from robots.bridges.core.transport import Publisher, Transport
from robots.client.cloud_url import path_of
from robots.client.rest import RestClient

logger = logging.getLogger(__name__)

PERIOD = 1.0
"""Time between two looks at tasks [s]."""

REQUESTS: Final[Mapping[Kind, str]] = {"dispenser": DISPENSER_REQUEST, "ingestor": INGESTOR_REQUEST}
RESULTS: Final[Mapping[Kind, str]] = {"dispenser": DISPENSER_RESULT, "ingestor": INGESTOR_RESULT}


class WorkcellBridge:
    """Asks workcells for the robots that hold for them, and confirms their tasks.

    Parameters
    ----------
    rest : RestClient
        Client of the user whose tasks they are.
    maps : collection of str
        Ids of the maps with tasks.
    fleet : str
        Name of the fleet, the type of transporter in requests.
    now : callable
        Clock of Open-RMF [s since the epoch].
    """

    def __init__(self, rest: RestClient, maps: Collection[str], fleet: str, now: Clock = epoch) -> None:
        self._rest, self._maps, self._now = rest, sorted(maps), now
        self._workcells, self._notices = Workcells(fleet), Notices()
        self._confirmations: asyncio.Queue[tuple[str, str]] = asyncio.Queue()

    async def serve(self, transport: Transport) -> None:
        """Serve in a graph that is open, until cancelled."""
        known = [kind for kind in KINDS if transport.has_type(REQUESTS[kind]) and transport.has_type(RESULTS[kind])]
        publishers = {kind: transport.publisher(f"/{kind}_requests", REQUESTS[kind], Qos()) for kind in known}
        for kind in known:
            transport.subscribe(f"/{kind}_results", RESULTS[kind], Qos(), partial(self._received, transport, kind))
        async with asyncio.TaskGroup() as group:
            group.create_task(self._look(transport, publishers))
            group.create_task(self._confirm())

    def _received(self, transport: Transport, kind: Kind, data: bytes) -> None:
        try:
            found = self._workcells.take(kind, transport.types.decode(RESULTS[kind], data), self._now())
        except PPaaSError as error:
            self._notices.warn(f"a result of a {kind} is refused: {error}")
            return
        if isinstance(found, tuple):
            self._confirmations.put_nowait(found)
        elif found:
            self._notices.warn(found)

    async def _look(self, transport: Transport, publishers: Mapping[Kind, Publisher]) -> None:
        while True:
            try:
                tasks = [task for name in self._maps for task in await self._open_tasks(name)]
            except PPaaSError as error:
                self._notices.warn(f"tasks for workcells are not known: {error}")
            else:
                for kind, message in self._workcells.see(tasks, self._now()):
                    if kind in publishers:
                        publishers[kind].publish(transport.types.encode(REQUESTS[kind], message))
                    else:
                        self._notices.warn(f"task {message['request_guid']} waits: this ROS has no package of {kind}s")
            await asyncio.sleep(PERIOD)

    async def _open_tasks(self, map_id: str) -> list[dict[str, object]]:
        return await self._rest.items(path_of("maps", map_id, "tasks"), state="open")

    async def _confirm(self) -> None:
        while True:
            map_id, task = await self._confirmations.get()
            try:
                await self._rest.post(path_of("maps", map_id, "tasks", task, "confirm"), {})
                logger.info("task %s goes on: its workcell is ready", task)
            except Conflict:
                logger.info("task %s was confirmed or ended meanwhile", task)
            except PPaaSError as error:
                self._notices.warn(f"task {task} cannot be confirmed: {error}")
                self._workcells.confirm_failed(task)
