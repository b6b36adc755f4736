"""Robot sessions as an endpoint has them: the clients of places, which the master counts."""

from collections import Counter
from dataclasses import dataclass

from engine.endpoint.master_link import MasterLink
from engine.endpoint.places import EndpointPlaces
from engine.master.places import robot_key
from engine.processes.background import Background
from engine.protocols.refusals import refusal_of
from engine.service.endpoints.interface import Join, JoinedPlace, MasterCalls
from engine.service.links.place_link import PlaceLink
from ppaas.errors import PPaaSError, Unavailable


@dataclass(frozen=True, slots=True)
class _Client:
    user: str
    robot: str
    as_robot: bool


class EndpointSessions:
    """Joins the places of robots for the clients of this endpoint; implements ``RobotPlaces``.

    Parameters
    ----------
    master : MasterLink
    places : EndpointPlaces
    """

    def __init__(self, master: MasterLink, places: EndpointPlaces) -> None:
        self._master = master
        self._places = places
        self._clients: Counter[_Client] = Counter()
        self._background = Background()

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
        """Add a client to the place of a robot and return the place; see ``RobotSessions.join``."""
        joined = await self._join(Join(user, robot, as_robot, hold, queue, session))
        if hold:
            self._clients[_Client(user, robot, as_robot)] += 1
        return self._places.joined(joined)

    async def _join(self, join: Join) -> JoinedPlace:
        return await self._master.call(MasterCalls.join, join)

    def leave(self, key: str, *, as_robot: bool) -> None:
        """Remove a client from a place."""
        client = next((one for one in self._clients if (_key(one), one.as_robot) == (key, as_robot)), None)
        if client is None:
            return
        self._clients[client] -= 1
        if not self._clients[client]:
            del self._clients[client]
        self._master.tell(MasterCalls.leave, key, as_robot)

    async def position(self, place: PlaceLink) -> int | None:
        """Return the position of a place in the queue, from 1; None if it is not queued."""
        return await self._master.call(MasterCalls.position, place.key)

    async def let_go(self, place: PlaceLink, reason: PPaaSError) -> None:
        """Close a place although clients are connected, and notify them of the reason."""
        await self._master.call(MasterCalls.let_go, place.key, refusal_of(reason))

    async def tell_clients(self) -> None:
        """Tell a master that this endpoint has found which clients it has; those that it refuses are notified."""
        for client, count in tuple(self._clients.items()):
            self._background.run(self._join_again(client, count))

    async def _join_again(self, client: _Client, count: int) -> None:
        join = Join(client.user, client.robot, client.as_robot, True, True)
        try:
            for _ in range(count):
                self._places.joined(await self._master.call_now(MasterCalls.join, join))
        except Unavailable:
            return  # the master was lost again
        except PPaaSError as error:
            self._places.close(_key(client), error)

    async def close(self) -> None:
        """End what runs in the background."""
        await self._background.cancel()


def _key(client: _Client) -> str:
    return robot_key(client.user, client.robot)
