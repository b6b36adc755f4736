"""Calls of the master about a user's robots on one map together: the people they see, their traffic and tasks."""

from typing import Protocol

from engine.service.views import PeopleGroupView
from ppaas.messages.fleet.traffic import TrafficState
from ppaas.messages.people_coordination import PeopleState, ZoneCount
from ppaas.people.settings import PeopleSettings


class PeopleCalls(Protocol):
    """People whom robots see."""

    async def views(self) -> list[PeopleGroupView]:
        """Return the groups of robots that track people now, and the states of their coordinators."""
        ...

    async def people(self, user: str, map_id: str) -> PeopleState:
        """Return the people whom the robots of a user see on a map.

        Raises
        ------
        Unavailable
            No robot of the user tracks people on the map, or their coordinator was refused or does not answer.
        """
        ...

    async def counts(self, user: str, map_id: str, since: int) -> list[ZoneCount]:
        """Return the numbers of different people by hour and zone, without hours that ended before a time.

        Raises
        ------
        Unavailable
            As ``people``.
        """
        ...

    async def configure(self, user: str, map_id: str, settings: PeopleSettings) -> None:
        """Make the coordinator of a user's robots on a map, if there is one, use settings that are stored already.

        Raises
        ------
        InvalidInput, NotFound
            The coordinator refuses the settings; NotFound if it has no rule of that name.
        Unavailable
            The coordinator does not answer.
        """
        ...


class TrafficCalls(Protocol):
    """Traffic of robots that drive by grants."""

    async def state(self, user: str, map_id: str) -> TrafficState:
        """Return the traffic of the robots of a user on a map.

        Raises
        ------
        Unavailable
            No robot of the user takes part in the traffic of the map, or its traffic node was refused or does not
            answer.
        """
        ...

    async def take_out(self, user: str, map_id: str, robot: str) -> None:
        """Take a robot of a user out of the traffic of a map: what it holds is free, and nobody waits for it.

        Raises
        ------
        NotFound
            The traffic node knows no such robot.
        Unavailable
            As ``state``.
        """
        ...

    async def put_back(self, user: str, map_id: str, robot: str) -> None:
        """Put a robot of a user back into the traffic of a map, where it now stands.

        Raises
        ------
        NotFound
            The traffic node knows no such robot.
        Unavailable
            As ``state``.
        """
        ...


class TaskCalls(Protocol):
    """Tasks of robots."""

    async def changed(self, user: str, map_id: str) -> None:
        """Read the tasks of a user on a map again, since one was added or cancelled.

        Raises
        ------
        Unavailable
            The master does not answer. It reads them later by itself.
        """
        ...
