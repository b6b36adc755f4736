"""Traffic groups: the traffic nodes of robots that drive by grants, opened, closed and called."""

from engine.service.group_places import GroupKind, GroupPlaces
from engine.service.master_driver import MasterDriver
from ppaas.clock import Clock, monotonic
from ppaas.messages import decode
from ppaas.messages.base.message import Empty
from ppaas.messages.fleet.traffic import RobotOfTraffic, TrafficState
from ppaas.traffic.taking_part import TRAFFIC, takes_part

LINGER = 60.0
"""Time for which a traffic node outlives the places of its robots [s]: until then an operator sees where they stopped,
and robots that come back need not wait for it."""

KIND = GroupKind(
    "traffic",
    "traffic node",
    TRAFFIC,
    takes_part,
    LINGER,
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
        self.places = GroupPlaces(KIND, service, clock)

    async def state(self, user: str, map_id: str) -> TrafficState:
        """Return the traffic of the robots of a user on a map."""
        return decode(TrafficState, await self.places.call(user, map_id, "get_traffic", Empty()))

    async def take_out(self, user: str, map_id: str, robot: str) -> None:
        """Take a robot out of the traffic: what it holds is free, and nobody waits for it."""
        await self.places.call(user, map_id, "take_out", RobotOfTraffic(robot))

    async def put_back(self, user: str, map_id: str, robot: str) -> None:
        """Put a robot back into the traffic, where it now stands."""
        await self.places.call(user, map_id, "put_back", RobotOfTraffic(robot))
