"""Places that an endpoint reaches: their links, which containers dial."""

from dataclasses import dataclass

from engine.service.endpoints.interface import JoinedPlace
from engine.service.links.place_link import PlaceLink
from ppaas.clock import Clock, monotonic
from ppaas.errors import PPaaSError

IDLE = 120.0
"""Time after its last use for which a place without clients is reached [s]."""


@dataclass(slots=True)
class _Reached:
    link: PlaceLink
    used: float


class EndpointPlaces:
    """Links of the places that clients of this endpoint use.

    Parameters
    ----------
    clock : callable
        Returns monotonic seconds.
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._reached: dict[str, _Reached] = {}

    def link(self, key: str) -> PlaceLink:
        """Return the link of a place by name; a container may dial before the master has answered."""
        reached = self._reached.get(key)
        if reached is None:
            reached = self._reached[key] = _Reached(PlaceLink(key), self._clock())
        reached.used = self._clock()
        return reached.link

    def running(self, key: str) -> PlaceLink | None:
        """Return the link of a place whose container is connected with this endpoint; None if there is none."""
        reached = self._reached.get(key)
        if reached is None or reached.link.container is None:
            return None
        reached.used = self._clock()
        return reached.link

    def joined(self, place: JoinedPlace) -> PlaceLink:
        """Return the link of a place that the master has opened."""
        link = self.link(place.key)
        link.base_frame, link.nearer = place.base_frame, place.nearer
        return link

    def close(self, key: str, reason: PPaaSError) -> None:
        """Close a place, and notify its clients."""
        reached = self._reached.pop(key, None)
        if reached is not None:
            reached.link.close(reason)

    def idle(self) -> list[str]:
        """Return the places without clients that were not used for a while."""
        latest = self._clock() - IDLE
        return [key for key, one in self._reached.items() if not one.link.has_clients and one.used < latest]

    def close_all(self, reason: PPaaSError) -> None:
        """Close all places, and notify their clients."""
        for key in tuple(self._reached):
            self.close(key, reason)
