"""Groups of robots that take part in the traffic of their map, and their traffic nodes."""

import logging

from engine.control.group_places import GroupKind, GroupPlaces, Key
from engine.control.master_driver import MasterDriver
from engine.processes.background import Background
from ppaas.clock import Clock, monotonic
from ppaas.errors import PPaaSError
from ppaas.messages import decode
from ppaas.messages.base.message import Empty
from ppaas.messages.fleet.traffic import RobotOfTraffic, TrafficState
from ppaas.traffic.taking_part import TRAFFIC, takes_part

logger = logging.getLogger(__name__)

TRAFFIC_LINGER = 60.0
"""Time for which a traffic node outlives the places of its robots [s]: until then an operator sees where they stopped,
and robots that come back need not wait for it."""

TRAFFIC_KIND = GroupKind(
    "traffic",
    "traffic node",
    TRAFFIC,
    takes_part,
    TRAFFIC_LINGER,
    "no robot of user {user} takes part in the traffic of map {map} now: set 'traffic' to true in the file of one, and "
    "connect it",
)


class TrafficGroups:
    """Gives each group of robots in the traffic of their map a traffic node, and calls it; implements ``TrafficCalls``.

    Parameters
    ----------
    service : MasterDriver
        Opens and closes places.
    clock : callable
        Returns monotonic seconds.

    Attributes
    ----------
    places : GroupPlaces
        Places of the traffic nodes.
    """

    def __init__(self, service: MasterDriver, clock: Clock = monotonic) -> None:
        self.places = GroupPlaces(TRAFFIC_KIND, service, clock, self._let_go)
        self._background = Background()

    async def state(self, user: str, map_id: str) -> TrafficState:
        """Return the traffic of the robots of a user on a map."""
        return decode(TrafficState, await self.places.call(user, map_id, "get_traffic", Empty()))

    def _let_go(self, key: Key, robot: str) -> None:
        """Let the traffic node of a map forget a robot that has left it; what it held is free."""
        if self.places.place(*key) is not None:
            self._background.run(self._forget(key, robot))

    async def _forget(self, key: Key, robot: str) -> None:
        try:
            await self.places.call(*key, "let_go", RobotOfTraffic(robot))
        except PPaaSError as error:
            logger.warning("the traffic node of map %r was not told that robot %s has left: %s", key[1], robot, error)

    async def take_out(self, user: str, map_id: str, robot: str) -> None:
        """Take a robot out of the traffic: what it holds is free, and nobody waits for it."""
        await self.places.call(user, map_id, "take_out", RobotOfTraffic(robot))

    async def put_back(self, user: str, map_id: str, robot: str) -> None:
        """Put a robot back into the traffic, where it now stands."""
        await self.places.call(user, map_id, "put_back", RobotOfTraffic(robot))
