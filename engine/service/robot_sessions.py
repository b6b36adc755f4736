"""Robots and their operators: who is connected to which place, and when a place is given up."""

import asyncio
import logging
from collections import Counter

from msgspec.structs import replace

from engine.container.monitor.parameters import with_priorities
from engine.master.places import PlaceRequest
from engine.service.links.place_link import PlaceLink
from engine.service.master_driver import CloudService
from engine.specs.containers import MapVersion, RobotConfig
from engine.specs.filter_masks import mask_versions
from ppaas.errors import Conflict, NotFound, NotPermitted, PPaaSError, Unavailable
from ppaas.robot_model.describe import describe
from ppaas.robot_model.description import RobotDescription
from storage.ports import MapStore, Store
from storage.records import RobotRecord
from storage.versions import OCTOMAP

logger = logging.getLogger(__name__)

LINGER = 30.0
"""Seconds that a clone waits for a client to come back before its container is given up."""


class RobotSessions:
    """Opens the place of a robot for its first client and closes it some time after the last has left.

    Parameters
    ----------
    service : CloudService
        Opens places.
    store, map_store
        Know the robots and the versions of their maps.
    linger : float
        Seconds that a place without clients is kept.
    node_priorities : tuple of str
        What the node monitor goes by, where a robot's file says nothing else; empty for its own order.
    """

    def __init__(
        self,
        service: CloudService,
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
        self._robots: set[str] = set()
        self._closing: dict[str, asyncio.Task[None]] = {}

    async def join(self, user: str, robot: str, *, as_robot: bool, hold: bool = True, queue: bool = False) -> PlaceLink:
        """Return the place of a robot for one more client, which must ``leave`` it.

        Parameters
        ----------
        user, robot : str
            Whose place it is.
        as_robot : bool
            It is the robot itself, of which there is one.
        hold : bool
            Open the place, and keep it open for this client. A client that does not hold it does not ``leave`` either.
        queue : bool
            Let the place wait for its turn where there is no container for it now.

        Raises
        ------
        NotFound
            The user has no such robot, or its map is gone.
        InvalidParameter
            A mask that the robot's file names is gone, or no grid.
        NotPermitted
            The user may no longer read the map.
        Conflict
            The robot is connected already.
        QuotaExceeded, Unavailable
            There is no container for it.
        """
        request = await asyncio.to_thread(self._request, user, robot)
        key = request.key
        if not hold:
            return self._open_already(key)
        if as_robot and key in self._robots:
            raise Conflict(f"robot {robot!r} is connected already; close its other socket first")
        place = await self._open(request, queue=queue)
        closing = self._closing.pop(key, None)
        if closing is not None:
            closing.cancel()
        self._clients[key] += 1
        if as_robot:
            self._robots.add(key)
        return place

    def _open_already(self, key: str) -> PlaceLink:
        place = self._service.place(key)
        if place is None:
            raise Unavailable("the robot has no container now: wait until it connects, or connect without hold=0")
        return place

    async def _open(self, request: PlaceRequest, *, queue: bool) -> PlaceLink:
        try:
            return self._service.open_place(request, queue=queue)
        except Conflict:
            if request.key not in self._closing:
                raise
        # Nobody is connected: what was changed meanwhile, as the map, need not wait for the old place to end.
        await self._service.close_place(request.key, Unavailable("its robot or map was changed"))
        return self._service.open_place(request, queue=queue)

    def position(self, place: PlaceLink) -> int | None:
        """Return the position of a place in the queue, the first being 1; None if it does not wait there."""
        return self._service.position(place.key)

    def _request(self, user: str, robot: str) -> PlaceRequest:
        record = self._store.robot(user, robot)
        urdf = self._urdf(user, robot)
        version = self._map_store.map_head(record.map)
        if not version.readable_by(user):
            raise NotPermitted(f"map {record.map!r} is not shared with {user!r}")
        config = robot_config(record, urdf)
        masks = mask_versions(self._map_store, user, config.parameters)
        parameters = with_priorities(config.parameters, self._node_priorities)
        in_space = OCTOMAP in version.present.files
        config = replace(config, parameters=parameters, masks=masks, in_space=in_space)
        return PlaceRequest(user, MapVersion(version.id, version.version), record.cores, config, labels=record.labels)

    def _urdf(self, user: str, robot: str) -> RobotDescription | None:
        try:
            return describe(self._store.urdf(user, robot))
        except NotFound:
            return None

    def leave(self, place: PlaceLink, *, as_robot: bool) -> None:
        """Take one client off a place."""
        key = place.key
        if as_robot:
            self._robots.discard(key)
        self._clients[key] -= 1
        if self._clients[key] <= 0:
            del self._clients[key]
            waits = self._service.position(key) is not None
            self._closing[key] = asyncio.create_task(self._close_later(key, 0.0 if waits else self._linger))

    def await_back(self, key: str) -> None:
        """Keep a place that goes on since another cloud process for as long as if its last client had left now."""
        if key not in self._clients and key not in self._closing:
            self._closing[key] = asyncio.create_task(self._close_later(key, self._linger))

    async def let_go(self, place: PlaceLink, reason: PPaaSError) -> None:
        """Give a place up though clients are connected, and tell them why."""
        if self._service.place(place.key) is place:
            await self._service.close_place(place.key, reason)

    async def _close_later(self, key: str, linger: float) -> None:
        await asyncio.sleep(linger)
        self._closing.pop(key, None)
        await self._service.close_place(key, Unavailable(f"nobody was connected for {linger:g} s"))

    async def close(self) -> None:
        """Forget what was to be closed later."""
        for task in self._closing.values():
            task.cancel()
        await asyncio.gather(*self._closing.values(), return_exceptions=True)


def robot_config(record: RobotRecord, urdf: RobotDescription | None = None) -> RobotConfig:
    """Return what a clone must know of its robot."""
    return RobotConfig(
        id=record.id,
        model=record.model,
        initial_pose=record.initial_pose,
        base_global_planner=record.base_global_planner,
        base_local_planner=record.base_local_planner,
        parameters=record.parameters,
        urdf=urdf,
    )
