"""Open places of robots, as those who follow robots see them."""

from typing import Protocol

from engine.links.place_link import PlaceLink
from engine.links.presence import RobotPresence
from engine.master.places import PlaceRequest


class OpenPlaces(Protocol):
    """Open places, as a driver of the master knows them."""

    @property
    def presence(self) -> RobotPresence:
        """Robots that are connected."""
        ...

    def place(self, key: str) -> PlaceLink | None:
        """Return the link of an open place, or None."""
        ...

    def request_of(self, key: str) -> PlaceRequest | None:
        """Return the request of an open or queued place, or None."""
        ...
