"""Interface of the engine to the sockets of robots and operators: the places of robots."""

from typing import Protocol

from engine.service.links.place_link import PlaceLink
from ppaas.errors import PPaaSError


class RobotPlaces(Protocol):
    """Places of robots, as endpoints see them; see ``engine.service.robot_sessions.RobotSessions``."""

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
        """Add a client to the place of a robot and return the place; with ``hold``, the client must ``leave`` it later.

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
        ...

    def leave(self, key: str, *, as_robot: bool) -> None:
        """Remove a client from a place."""
        ...

    async def position(self, place: PlaceLink) -> int | None:
        """Return the position of a place in the queue, from 1; None if it is not queued."""
        ...

    async def let_go(self, place: PlaceLink, reason: PPaaSError) -> None:
        """Close a place although clients are connected, and notify them of the reason."""
        ...
