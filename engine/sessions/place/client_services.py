"""Client services: services that clients of a place advertise, and the open calls of them."""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import partial
from typing import Protocol

from engine.links.open_calls import Done, OpenCalls, Outcome
from engine.sessions.place.asked_clients import client_asked
from engine.sessions.place.message_completion import ServiceCompletion, service_completion
from ppaas.errors import MalformedMessage, NotFound, NotPermitted, PPaaSError, QuotaExceeded, Unavailable
from ppaas.messages.base.spelling import to_ros2

MAX_SERVICES = 200
"""Largest number of services that the clients of one place may advertise."""


class Provider(Protocol):
    """Client that answers calls, as a place sees it. Its method must not block."""

    def requested(self, call: int, service: str, payload: bytes) -> None:
        """Send a service call to the client, whose answer is passed to ``ClientServices.answer``.

        Raises
        ------
        Unavailable
            The client is too slow to take calls.
        """
        ...


@dataclass(frozen=True, slots=True)
class _Offer:
    type: str
    client: int
    provider: Provider
    ros2: bool
    completion: ServiceCompletion


class ClientServices:
    """Services that the clients of one place advertise."""

    def __init__(self) -> None:
        self._offers: dict[str, _Offer] = {}
        self._calls = OpenCalls()

    def __contains__(self, service: str) -> bool:
        """Return whether a client advertises a service."""
        return service in self._offers

    def type_of(self, service: str) -> str | None:
        """Return the type of a service; None if no client advertises it."""
        offer = self._offers.get(service)
        return offer.type if offer is not None else None

    def answers_in_ros2(self, service: str) -> bool:
        """Return whether callers that name no type get the completed responses of a service as spelled in ROS 2."""
        offer = self._offers.get(service)
        return offer is not None and offer.ros2 and offer.completion.response is not None

    def types(self) -> dict[str, str]:
        """Return the services and their types, by the names of ROS 1."""
        return {name: offer.type for name, offer in self._offers.items()}

    # -- advertisements ------------------------------------------------------------------------------------------------

    def advertise(self, service: str, kind: str, client: int, provider: Provider, *, ros2: bool = False) -> None:
        """Advertise a service. The newest client takes it over, so that a reconnecting client need not wait.

        Parameters
        ----------
        service : str
        kind : str
            Type of the service, by its name in ROS 1.
        client : int
            Number of the client.
        provider : Provider
            Gets the calls.
        ros2 : bool
            Whether the client spells messages as in ROS 2.

        Raises
        ------
        QuotaExceeded
            The clients of this place advertise too many services.
        """
        if service not in self._offers and len(self._offers) >= MAX_SERVICES:
            raise QuotaExceeded(
                f"the clients of a robot may advertise at most {MAX_SERVICES} services: unadvertise one first"
            )
        self._offers[service] = _Offer(kind, client, provider, ros2, service_completion(kind))

    def unadvertise(self, service: str, client: int) -> None:
        """Withdraw a service; open calls may still be answered.

        Raises
        ------
        NotFound
            The client does not advertise it.
        """
        offer = self._offers.get(service)
        if offer is None or offer.client != client:
            raise NotFound("offered service", service, [s for s, o in self._offers.items() if o.client == client])
        del self._offers[service]

    def leave(self, client: int) -> None:
        """Withdraw all services of a client and fail its open calls."""
        self._offers = {name: offer for name, offer in self._offers.items() if offer.client != client}
        for number, call in self._calls:
            if call.client == client:
                self._calls.end(
                    number, Unavailable(f"the client that provides service {call.service!r} has disconnected")
                )

    def overtaken(self, services: Collection[str]) -> None:
        """Fail the open calls of services that the clone provides from now on, since their client may be lost."""
        for number, call in self._calls:
            if call.service in services:
                self._calls.end(
                    number, Unavailable(f"the clone now provides service {call.service!r} itself; call again")
                )

    # -- calls ---------------------------------------------------------------------------------------------------------

    def begin(self, service: str, payload: bytes, timeout: float, done: Done) -> Callable[[], object]:
        """Call a service of a client; ``done`` is called once with the outcome.

        Request and response are completed if the cloud knows the type of the service.

        Returns
        -------
        callable
            Cancels the call: ``done`` is not called any more.

        Raises
        ------
        MalformedMessage
            The request is not one of the type of the service.
        Unavailable
            The client is too slow to take calls, or fails.
        """
        offer = self._offers[service]
        if offer.completion.request is not None:
            payload = offer.completion.request(payload)
            payload = to_ros2(payload) if offer.ros2 else payload
        number = self._calls.open(service, timeout, done, offer.client, offer.completion.response)
        try:
            with client_asked(f"service {service!r}"):
                offer.provider.requested(number, service, payload)
        except PPaaSError:
            self._calls.give_up(number)
            raise
        return partial(self._calls.give_up, number)

    def answer(self, number: int, client: int, answer: Outcome) -> None:
        """Take a client's answer to a call: JSON, or an error.

        Raises
        ------
        MalformedMessage
            It is not a response of the type of the service; the call has failed with this error.
        NotFound
            No such call is open; it was answered, timed out or was cancelled.
        NotPermitted
            The call was sent to another client.
        """
        try:
            call = self._calls[number]
        except KeyError as error:
            raise NotFound("open call", str(number)) from error
        if call.client != client:
            raise NotPermitted(f"call {number} was sent to another client")
        if call.complete is not None and isinstance(answer, bytes):
            try:
                answer = call.complete(answer)
            except MalformedMessage as error:
                wrong = MalformedMessage(f"the response of service {call.service!r}: {error}")
                self._calls.end(number, wrong)
                raise wrong from error
        self._calls.end(number, answer)
