"""Robot on a journey, as the site of a building reaches it."""

from typing import Protocol

from ppaas.buildings.layout import Place
from ppaas.messages.fleet.floors import FindFloorRequest, FindFloorResponse


class Rider(Protocol):
    """Robot on a journey, as a site reaches it."""

    @property
    def is_here(self) -> bool:
        """Whether the robot is connected, and has a container."""
        ...

    @property
    def map(self) -> str:
        """Map that its container is on; empty while it has none that is ready."""
        ...

    @property
    def pose(self) -> Place | None:
        """Its pose on that map; None if it is not known, or not any more."""
        ...

    def send(self, goal_id: str, pose: Place) -> None:
        """Send a goal, unless one of that id was sent."""
        ...

    def cancel(self, goal_id: str) -> None:
        """Cancel a goal."""
        ...

    async def change_map(self, map_id: str, pose: Place) -> None:
        """Let its clone go on on another map."""
        ...

    async def find_floor(self, request: FindFloorRequest) -> FindFloorResponse:
        """Ask its clone on which floor it is; ``NotFound`` or ``Conflict`` if that cannot compare scans with maps."""
        ...

    def leave(self) -> None:
        """Follow it no longer."""
        ...
