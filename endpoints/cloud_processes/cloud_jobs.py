"""Jobs that a cloud has one of, however many endpoints it has: watches, and work that no request asks for."""

import asyncio
from collections import defaultdict
from collections.abc import Sequence
from typing import Protocol

from endpoints.merging.coordinator import JointMapCoordinator
from endpoints.people.counting import PeopleCounting
from endpoints.proposals.change_watch import ChangeWatch
from endpoints.resources.removal import RemovedUsers
from endpoints.resources.services import Services
from endpoints.resources.store_health import DiskWatch
from engine.control.fleet_events import FleetEvents
from engine.control.robot_sessions import IdleWatch, RobotSessions
from engine.control.tasks.runner import TaskRunner
from engine.links.place_link import PlaceLink
from engine.processes.background import Background, repeat
from engine.specs.robot_maps import owner_by
from ppaas.errors import NotFound, NotPermitted, Unavailable

# Map rights watch: closes places whose map is no longer shared with their user.
#
# It polls, instead of being notified, so it also sees what another process changed in the store.

PERIOD = 0.5
"""Interval of the checks [s]."""


class MapRightsWatch:
    """Closes places whose map or mask is no longer shared with the owner of their robot.

    A robot that makes a joint map with another user's robots reconnects, and then maps apart from them.

    Parameters
    ----------
    robots : RobotSessions
        Places of the robots.
    services : Services
        Services with the maps.
    """

    def __init__(self, robots: RobotSessions, services: Services) -> None:
        self._robots = robots
        self._services = services

    async def run(self) -> None:
        """Check all places periodically until cancelled."""
        await repeat(self.check, PERIOD)

    async def check(self) -> None:
        """Check all places once; a right that cannot be checked now, as its store is unreachable, remains."""
        by_map: defaultdict[str, list[PlaceLink]] = defaultdict(list)
        held = self._robots.held()
        for place in held:
            for map_id in self._robots.map_ids(place):
                by_map[map_id].append(place)
        await asyncio.gather(
            *(self._check_map(map_id, places) for map_id, places in by_map.items()),
            *(self._check_joint_map(place) for place in held),
        )

    async def _check_map(self, map_id: str, places: list[PlaceLink]) -> None:
        try:
            head = await self._services.map_cache.head(self._services.map_store, map_id)
        except (NotFound, Unavailable):
            return  # a map in use is not removed, except by another process: what is loaded stays usable
        for place in places:
            user = self._robots.owner(place)
            if user and not head.readable_by(user):
                await self._robots.let_go(place, NotPermitted(f"map {map_id!r} is no longer shared with {user!r}"))

    async def _check_joint_map(self, place: PlaceLink) -> None:
        joint, user = self._robots.joint_map(place), self._robots.owner(place)
        if joint is None:
            return
        map_id, owner = joint
        try:
            head = await self._services.map_cache.head(self._services.map_store, map_id)
            if owner_by(head, user) == owner:
                return
        except Unavailable:
            return
        except NotFound:
            pass  # it was removed, and is shared with nobody
        await self._robots.let_go(
            place, Unavailable(f"map {map_id!r} of {owner!r} is no longer shared with {user!r}: connect again")
        )


class CloudJob(Protocol):
    """Job that a cloud has one of."""

    async def run(self) -> None:
        """Do it until cancelled."""
        ...


class CloudJobs:
    """Runs the jobs in the process of the master.

    Parameters
    ----------
    services : Services
        Services of the cloud; the caller closes them.
    robots : RobotSessions
        Places of robots.
    idle : float
        Time without frames after which a robot is disconnected [s]; 0 disables this.
    tasks : TaskRunner
        Leads the tasks of robots.
    events : FleetEvents
        Reports what happens to the cloud.
    others : sequence of CloudJob
        Jobs that endpoints call, too.

    Attributes
    ----------
    idle : IdleWatch
        Disconnects idle robots.
    """

    def __init__(
        self,
        services: Services,
        robots: RobotSessions,
        idle: float,
        tasks: TaskRunner,
        *,
        events: FleetEvents,
        others: Sequence[CloudJob] = (),
    ) -> None:
        self.idle = IdleWatch(robots, idle)
        self._jobs: tuple[CloudJob, ...] = (
            self.idle,
            MapRightsWatch(robots, services),
            DiskWatch.of(services.disk, services.store, events.disk_changed),
            ChangeWatch(services),
            RemovedUsers(services),
            PeopleCounting(services),
            JointMapCoordinator(services),
            tasks,
            *others,
        )
        self._background = Background()

    def start(self) -> None:
        """Start all jobs."""
        for job in self._jobs:
            self._background.run(job.run())

    async def close(self) -> None:
        """Cancel all jobs."""
        await self._background.cancel()
