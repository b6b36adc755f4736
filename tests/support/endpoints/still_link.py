"""Endpoint's end of the link to a place without sockets: frames arrive at once, without a stream."""

import msgspec

from engine.links.place_link import PlaceLink
from engine.protocols import robot_link
from engine.protocols.session_frames import ClientOffers
from engine.sessions.host import SessionHost
from tests.support.endpoints.still_place import StillPlace


class _ToEndpoint:
    waiting = 0

    def __init__(self, link: "StillLink") -> None:
        self._link = link

    def write(self, frame: msgspec.Struct) -> None:
        self._link.take(frame)  # type: ignore[arg-type]


class _ToContainer:
    waiting = 0

    def __init__(self, host: SessionHost, end: _ToEndpoint) -> None:
        self._host = host
        self._end = end

    def write(self, frame: msgspec.Struct) -> None:
        if not isinstance(frame, robot_link.Shutdown):  # there is no container to end
            self._host.take(self._end, frame)  # type: ignore[arg-type]


class StillLink(PlaceLink):
    """Carries sessions of a place whose container is played by the test."""

    def __init__(self, place: StillPlace) -> None:
        super().__init__(place.key)
        self.still = place
        self.host = SessionHost(place)
        self.topics, self.services, self.nodes = place.topics, place.services, place.nodes
        end = _ToEndpoint(self)
        self.host.link_up(end)
        self._stream = _ToContainer(self.host, end)

    @property
    def offers(self) -> ClientOffers:  # type: ignore[override]
        """What clients offer now."""
        place = self.still
        return ClientOffers(
            place.client_topics.types(), place.offered_services(), place.offered_actions(), sorted(place.heard())
        )

    @offers.setter
    def offers(self, offers: ClientOffers) -> None:
        """Ignore what is told: it is known at once."""
