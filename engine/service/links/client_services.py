"""Services that clients of a place offer, and the calls of them that are under way."""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import partial
from typing import Protocol

from engine.service.links.open_calls import Done, OpenCalls, Outcome
from ppaas.errors import NotFound, NotPermitted, QuotaExceeded, Unavailable

MAX_SERVICES = 200
"""Services that the clients of one place may offer."""


class Provider(Protocol):
    """A client that answers calls, as a place sees it. This may not block."""

    def requested(self, call: int, service: str, payload: bytes) -> None:
        """Take a call of a service that the client offers; it is answered by ``ClientServices.answer``.

        Raises
        ------
        Unavailable
            The client is too slow to be asked.
        """
        ...


@dataclass(frozen=True, slots=True)
class _Offer:
    type: str
    client: int
    provider: Provider


class ClientServices:
    """What the clients of one place offer."""

    def __init__(self) -> None:
        self._offers: dict[str, _Offer] = {}
        self._calls = OpenCalls()

    def __contains__(self, service: str) -> bool:
        """Tell whether some client offers a service."""
        return service in self._offers

    def type_of(self, service: str) -> str | None:
        """Return the type of a service; None if nobody offers it."""
        offer = self._offers.get(service)
        return offer.type if offer is not None else None

    def types(self) -> dict[str, str]:
        """Return the services and their types, as ROS 1 spells them."""
        return {name: offer.type for name, offer in self._offers.items()}

    # -- who offers ----------------------------------------------------------------------------------------------------

    def advertise(self, service: str, kind: str, client: int, provider: Provider) -> None:
        """Offer a service. The newest takes it over: a client that comes back need not wait until its old self is gone.

        Raises
        ------
        QuotaExceeded
            There are too many.
        """
        if service not in self._offers and len(self._offers) >= MAX_SERVICES:
            raise QuotaExceeded(f"the clients of a robot may offer {MAX_SERVICES} services: unadvertise some first")
        self._offers[service] = _Offer(kind, client, provider)

    def unadvertise(self, service: str, client: int) -> None:
        """Offer a service no more; calls under way may still be answered.

        Raises
        ------
        NotFound
            The client does not offer it.
        """
        offer = self._offers.get(service)
        if offer is None or offer.client != client:
            raise NotFound("offered service", service, [s for s, o in self._offers.items() if o.client == client])
        del self._offers[service]

    def leave(self, client: int) -> None:
        """Take back all that a client offers, and tell who waits for it."""
        self._offers = {name: offer for name, offer in self._offers.items() if offer.client != client}
        for number, call in self._calls:
            if call.client == client:
                self._calls.end(number, Unavailable(f"the client that offers {call.service!r} has gone"))

    def overtaken(self, services: Collection[str]) -> None:
        """End the calls of services that the clone itself answers from now on: who was asked may be lost."""
        for number, call in self._calls:
            if call.service in services:
                self._calls.end(number, Unavailable(f"the clone answers {call.service!r} itself now; call again"))

    # -- calls ---------------------------------------------------------------------------------------------------------

    def begin(self, service: str, payload: bytes, timeout: float, done: Done) -> Callable[[], object]:
        """Let the client that offers a service answer; ``done`` gets the outcome, once.

        Returns
        -------
        callable
            Gives the call up: ``done`` is not called any more.

        Raises
        ------
        Unavailable
            The client is too slow to be asked.
        """
        offer = self._offers[service]
        number = self._calls.open(service, timeout, done, offer.client)
        try:
            offer.provider.requested(number, service, payload)
        except Unavailable:
            self._calls.give_up(number)
            raise
        return partial(self._calls.give_up, number)

    def answer(self, number: int, client: int, answer: Outcome) -> None:
        """Take the answer to a call: JSON, or why there is none.

        Raises
        ------
        NotFound
            No such call is open: it was answered already, or nobody waits for it any more.
        NotPermitted
            Another client was asked.
        """
        try:
            asked = self._calls[number].client
        except KeyError as error:
            raise NotFound("open call", str(number)) from error
        if asked != client:
            raise NotPermitted(f"call {number} was put to another client")
        self._calls.end(number, answer)
