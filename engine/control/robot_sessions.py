"""Robot sessions: counts the clients of each robot's place, and closes the place some time after the last has left.

Places of robots whose clients are idle are closed too, so that their containers are free for others.
"""

import asyncio
import contextlib
import dataclasses
import logging
from collections import Counter
from collections.abc import Iterable

from msgspec.structs import replace

from engine.container.monitor.parameters import with_priorities
from engine.control.master_driver import MasterDriver
from engine.links.place_link import PlaceLink
from engine.master.places import LINGER, PlaceRequest, robot_key
from engine.processes.background import cancel_all, repeat
from engine.specs.containers import MapVersion
from engine.specs.robot_places import check_readable, robot_place, urdf_of
from ppaas.clock import Clock, monotonic
from ppaas.errors import Conflict, Idle, NotFound, PPaaSError, Unavailable
from ppaas.maps.new_map import new_map_id
from ppaas.traffic.taking_part import TRAFFIC, with_traffic
from storage.ports import MapStore, Store
from storage.records import MapRecord
from storage.versions import OCTOMAP, YAML

logger = logging.getLogger(__name__)


class RobotSessions:
    """Opens the place of a robot for its first client, and closes it some time after the last has left.

    Parameters
    ----------
    service : MasterDriver
        Opens and closes places.
    store : Store
        Store of the robots.
    map_store : MapStore
        Store of the map versions.
    linger : float
        Time for which a place without clients is kept [s].
    node_priorities : tuple of str
        Priorities of the node monitor, unless a robot's file sets its own; empty for the default order.
    """

    def __init__(
        self,
        service: MasterDriver,
        store: Store,
        map_store: MapStore,
        linger: float = LINGER,
        *,
        node_priorities: tuple[str, ...] = (),
    ) -> None:
        self._node_priorities = node_priorities
        self._service = service
        self._store = store
        self._map_store = map_store
        self._linger = linger
        self._clients: Counter[str] = Counter()
        self._closing: dict[str, asyncio.Task[None]] = {}

    async def join(
        self,
        user: str,
        robot: str,
        *,
        as_robot: bool,
        hold: bool = True,
        queue: bool = False,
        session: str | None = None,
    ) -> PlaceLink:
        """Add a client to the place of a robot and return the place; the client must ``leave`` it later.

        An operator joins the place that is there, also if the robot's file or map was changed since it was opened: it
        may want to stop the robot. The robot itself gets a place with the changes, in favour of which an earlier one is
        closed.

        Parameters
        ----------
        user, robot : str
            User and name of the robot.
        as_robot : bool
            Whether the client is the robot itself, which may connect once only.
        hold : bool
            Whether to open the place and keep it open for this client. Without it, the place must be open already, the
            client is not counted, and it must not ``leave``.
        queue : bool
            Whether the place may wait for its turn if no container is available now.
        session : str, optional
            Name of the client's session; of no use within one process.

        Raises
        ------
        NotFound
            The user has no such robot, or its map was deleted.
        InvalidParameter
            A mask that the robot's file names does not exist, or is not a grid; or a robot with a new map has one.
        NotPermitted
            The user may no longer read the map.
        Conflict
            The robot is connected already.
        QuotaExceeded, Unavailable
            No container is available.
        """
        key = robot_key(user, robot)
        place = None if as_robot else await self._open_already(user, robot)
        if not hold:
            if place is None:
                raise Unavailable("the robot has no container now: wait until it connects, or connect without hold=0")
            return place
        if place is None:
            request, heads = await asyncio.to_thread(self._request, user, robot)
            self._check_single(user, robot, as_robot=as_robot)
            self._follow(heads)
            place = await self._open(request, queue=queue)
            # Again, since another socket of the robot may have come meanwhile.
            self._check_single(user, robot, as_robot=as_robot)
        closing = self._closing.pop(key, None)
        if closing is not None:
            closing.cancel()
        self._clients[key] += 1
        if as_robot:
            self._service.presence.came(key)
        return place

    def _check_single(self, user: str, robot: str, *, as_robot: bool) -> None:
        if as_robot and self._service.presence.has_socket(robot_key(user, robot)):
            raise Conflict(f"robot {robot!r} is connected already; close its other socket first")

    async def _open_already(self, user: str, robot: str) -> PlaceLink | None:
        """Return the place of a robot if it is open and the user may join it."""
        await asyncio.to_thread(self._check_rights, user, robot)
        return self._service.place(robot_key(user, robot))

    def _check_rights(self, user: str, robot: str) -> None:
        name = self._store.robot(user, robot).map
        if new_map_id(name) is not None:
            return
        with contextlib.suppress(NotFound):  # the map was deleted; the robot may still drive on it
            check_readable(self._map_store.map_head(name), user)

    async def _open(self, request: PlaceRequest, *, queue: bool) -> PlaceLink:
        try:
            return self._service.open_place(request, queue=queue)
        except Conflict:
            request = self._as_begun(request)
        with contextlib.suppress(Conflict):
            return self._service.open_place(request, queue=queue)
        known = self._service.request_of(request.key)
        if known is not None and _moved_to(known, request) == request:
            self._service.move_place(request)
            return self._service.open_place(request, queue=queue)
        # The robot is not connected, so the old place is closed in favour of the changed robot or map.
        await self._service.close_place(request.key, Unavailable("its robot or map was changed"))
        return self._service.open_place(request, queue=queue)

    async def moved(self, user: str, robot: str) -> None:
        """Let the clone of a robot go on with the map in its file, at the initial pose there, in the same session.

        Other changes of the file are used when the robot connects again. A robot without a place begins on the map when
        it connects.

        Raises
        ------
        NotFound, NotPermitted, InvalidMap, InvalidParameter
            As ``join``.
        """
        key = robot_key(user, robot)
        if self._service.request_of(key) is None:
            return
        request, heads = await asyncio.to_thread(self._request, user, robot)
        self._follow(heads)
        known = self._service.request_of(key)
        if known is not None:
            self._service.move_place(_moved_to(known, request))

    def _follow(self, heads: Iterable[MapRecord]) -> None:
        """Move open places to the versions of a map and its masks that another cloud has published.

        If another version was published since they were read, the request gets that one.
        """
        for head in heads:
            files = head.present.files
            if YAML in files:
                version = MapVersion(head.id, head.version)
                self._service.map_changed(version, head.present.number, in_space=OCTOMAP in files)

    def _as_begun(self, request: PlaceRequest) -> PlaceRequest:
        """Return a request with the version of the continued map, and its owner, with which its open place began.

        Its robot has made more of the map since, which would be lost with the place.
        """
        known, robot = self._service.request_of(request.key), request.robot
        begun = None if known is None else known.robot
        if robot is None or begun is None:
            return request
        if robot.continued is not None and begun.continued is not None and begun.continued.id == robot.continued.id:
            robot = replace(robot, continued=begun.continued)
        return dataclasses.replace(request, robot=replace(robot, map_owner=begun.map_owner))

    async def position(self, place: PlaceLink) -> int | None:
        """Return the position of a place in the queue, from 1; None if it is not queued."""
        return self._service.position(place.key)

    def _request(self, user: str, robot: str) -> tuple[PlaceRequest, list[MapRecord]]:
        record = self._store.robot(user, robot)
        place = robot_place(self._map_store, record, urdf_of(self._store, user, robot))
        parameters = with_priorities(place.config.parameters, self._node_priorities)
        config = replace(place.config, parameters=parameters)
        return PlaceRequest(user, place.map, record.cores, config, labels=record.labels), place.heads

    def leave(self, key: str, *, as_robot: bool) -> None:
        """Remove a client from a place."""
        if as_robot:
            self._service.presence.left(key)
        self._clients[key] -= 1
        if self._clients[key] <= 0:
            del self._clients[key]
            # A place in the queue has no clone that a robot could come back to.
            waits = self._service.position(key) is not None
            self._closing[key] = asyncio.create_task(self._close_later(key, 0.0 if waits else self._linger))

    def await_back(self, key: str) -> None:
        """Keep an adopted place for the time of ``linger``, as if its last client had left now."""
        if key not in self._clients and key not in self._closing:
            self._service.presence.expect(key)
            self._closing[key] = asyncio.create_task(self._close_later(key, self._linger))

    def held(self) -> list[PlaceLink]:
        """Return the places that have clients."""
        return [place for key in self._clients if (place := self._service.place(key)) is not None]

    def owner(self, place: PlaceLink) -> str:
        """Return the user whose robot a place is for; empty if it is closed."""
        request = self._service.request_of(place.key)
        return "" if request is None else request.user

    def map_ids(self, place: PlaceLink) -> tuple[str, ...]:
        """Return the ids of the map and the masks of a place; empty if it is closed, or makes a new map."""
        request = self._service.request_of(place.key)
        if request is None or (request.robot is not None and request.robot.new_map):
            return ()
        masks = request.robot.masks.values() if request.robot is not None else ()
        return (request.map.id, *(mask.id for mask in masks))

    def joint_map(self, place: PlaceLink) -> tuple[str, str] | None:
        """Return the id of a new map, and the other user with whose robots the one of a place makes it; else None."""
        request = self._service.request_of(place.key)
        robot = None if request is None else request.robot
        if request is None or robot is None or robot.continued is not None or robot.map_owner in ("", request.user):
            return None
        return robot.new_map, robot.map_owner

    async def let_go(self, place: PlaceLink, reason: PPaaSError) -> None:
        """Close a place although clients are connected, and notify them of the reason."""
        if self._service.place(place.key) is place:
            await self._service.close_place(place.key, reason)

    async def _close_later(self, key: str, linger: float) -> None:
        await asyncio.sleep(linger)
        self._closing.pop(key, None)
        self._service.presence.give_up(key)
        await self._service.close_place(key, Unavailable(f"no client was connected for {linger:g} s"))

    async def close(self) -> None:
        """Cancel all pending closes."""
        for task in self._closing.values():
            task.cancel()
        await asyncio.gather(*self._closing.values(), return_exceptions=True)


def _moved_to(known: PlaceRequest, request: PlaceRequest) -> PlaceRequest:
    """Return the request of an open place on the map of another, which has its robot; unchanged if one is made."""
    before, after = known.robot, request.robot
    if before is None or after is None or before.new_map or after.new_map:
        return known
    there = replace(
        before,
        initial_pose=after.initial_pose,
        in_space=after.in_space,
        parameters=with_traffic(before.parameters, after.parameters.get(TRAFFIC, False)),
    )
    return dataclasses.replace(known, map=request.map, robot=there)


IDLE = 600.0
"""Time without frames and without a goal after which a robot is disconnected [s]."""

CHECKS = 10
"""Number of checks of all places within that time."""


class IdleWatch:
    """Closes places whose clients are connected but send nothing, and whose robot has no goal.

    Silence is measured per place, not per client: an operator who only watches does not disconnect a driving robot.

    Parameters
    ----------
    robots : RobotSessions
        Has the places, and closes them.
    idle : float
        Time after which a place is closed [s]; 0 disables the watch.
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(self, robots: RobotSessions, idle: float = IDLE, clock: Clock = monotonic) -> None:
        self._robots = robots
        self._idle = idle
        self._clock = clock
        self._known: dict[PlaceLink, tuple[int, float]] = {}
        self._changed = asyncio.Event()

    def change(self, idle: float) -> None:
        """Close places after another time [s]; 0 disables the watch."""
        self._idle = idle
        self._changed.set()

    async def run(self) -> None:
        """Check all places periodically until cancelled."""
        while True:
            self._changed.clear()
            checks = [asyncio.create_task(repeat(self.check, self._idle / CHECKS))] if self._idle else []
            try:
                await self._changed.wait()
            finally:
                await cancel_all(checks)

    async def check(self) -> None:
        """Close places that have been idle for too long."""
        now = self._clock()
        before, self._known = self._known, {}
        for place in self._robots.held():
            taken = place.beat.frames + place.beat.sockets
            counted, since = before.get(place, (-1, now))
            self._known[place] = (taken, now if place.busy or taken != counted else since)
        for place, (_, since) in self._known.items():
            if now - since >= self._idle:
                text = f"no frames for {self._idle:g} s: connect again when you have something to send"
                await self._robots.let_go(place, Idle(text))
