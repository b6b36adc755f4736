"""Calls of the master about maps in use, and about the robots that make maps."""

from typing import Protocol

from engine.calls.interface import notice
from engine.service.views import LifelongRobot, MappingRobot
from storage.records import MapRecord


class MapCalls(Protocol):
    """Maps that robots drive on or make."""

    @notice
    async def changed(self, head: MapRecord) -> None:
        """Move the robots that drive on a map, or have it as a mask, to its current version.

        Every change of the current version must be followed by it.
        """
        ...

    async def end_groups(self, map_id: str) -> None:
        """End the people coordinators and traffic nodes of a map that no robot uses and that is removed.

        They outlive their robots for a while, and would store their checkpoints again.
        """
        ...

    async def mapping_robots(self) -> list[MappingRobot]:
        """Return the robots that make new maps now, except those that continue a published one."""
        ...

    async def lifelong_robots(self) -> list[LifelongRobot]:
        """Return the robots that continue a published map for life now."""
        ...
