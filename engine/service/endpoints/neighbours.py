"""All endpoints of a cloud, for what one of them needs of another."""

from collections.abc import Iterator
from typing import Protocol

from engine.master.places import robot_key
from engine.service.endpoints.interface import EndpointState, Join, Registration
from engine.service.views import EndpointView
from ppaas.clock import Clock, monotonic

DISPLACE_TIMEOUT = 4.0
"""Time limit of an endpoint to find out whether the socket of a robot is dead [s]."""

SILENT = 2.5
"""Time since its last report after which an endpoint counts as silent [s]; it reports once a second."""

_NOT_MEASURED = EndpointState(0, 0.0, 0.0, 0)
"""Load of an endpoint that has not reported yet."""


class Neighbour(Protocol):
    """Endpoint, as others see it."""

    registration: Registration | None
    state: EndpointState | None
    beats: int
    heard: float

    def has_robot(self, key: str) -> bool:
        """Return whether the endpoint has the socket of the robot of a place."""
        ...

    def hang_up(self) -> None:
        """Close the link to the endpoint."""
        ...

    async def displace(self, user: str, robot: str, session: str | None, timeout: float) -> None:
        """Let the endpoint displace the socket of a robot, if it is dead or of the same session."""
        ...


class Neighbours:
    """The registered endpoints; implements ``NeighbourCalls``.

    Parameters
    ----------
    clock : callable
        Returns monotonic seconds.
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self.clock = clock
        self._endpoints: list[Neighbour] = []

    def __iter__(self) -> Iterator[Neighbour]:
        """Iterate over a copy, so that endpoints may come and go meanwhile."""
        return iter(tuple(self._endpoints))

    def beats(self) -> dict[str, int]:
        """Return the number of reports of each endpoint, by name."""
        return {one.registration.endpoint: one.beats for one in self if one.registration is not None}

    async def views(self) -> list[EndpointView]:
        """Return the states of the endpoints."""
        latest = self.clock() - SILENT
        return [
            _view(one.registration, one.state or _NOT_MEASURED, is_silent=one.heard < latest)
            for one in self
            if one.registration is not None
        ]

    def add(self, endpoint: Neighbour) -> None:
        """Add an endpoint that has registered."""
        self._endpoints.append(endpoint)

    def hang_up(self, name: str) -> None:
        """Close the link to an endpoint; another process with its name may register."""
        for endpoint in self:
            if endpoint.registration is not None and endpoint.registration.endpoint == name:
                endpoint.hang_up()

    def remove(self, endpoint: Neighbour) -> None:
        """Remove an endpoint, if it was added."""
        if endpoint in self._endpoints:
            self._endpoints.remove(endpoint)

    async def displace(self, endpoint: Neighbour, join: Join) -> None:
        """Let the other endpoint that has the socket of a robot displace it, if it is dead or of the same session."""
        key = robot_key(join.user, join.robot)
        for other in self:
            if other is not endpoint and other.has_robot(key):
                await other.displace(join.user, join.robot, join.session, DISPLACE_TIMEOUT)

    def nearer(self, here: Registration, machine: str | None) -> str:
        """Return the address of the endpoint with the fewest sockets on a machine; empty if ``here`` is there, too."""
        if machine is None or machine == here.at.machine:
            return ""
        there = [
            ((one.state or _NOT_MEASURED).sockets, one.registration.advertised)
            for one in self
            if one.registration is not None and one.registration.at.machine == machine and one.registration.advertised
        ]
        return min(there)[1] if there else ""


def _view(here: Registration, state: EndpointState, *, is_silent: bool) -> EndpointView:
    return EndpointView(
        id=here.endpoint,
        machine=here.at.machine,
        pid=here.pid,
        url=here.advertised or here.url,
        release=here.release,
        sockets=state.sockets,
        frames=state.frames,
        cpu=state.cpu,
        memory=state.memory,
        state="silent" if is_silent else "ready",
    )
