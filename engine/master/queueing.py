"""Queue of requests that wait for a container instead of being refused."""

from collections.abc import Callable

from engine.master.orders import Order
from engine.master.placement_diagnostics import FullMachines
from engine.master.places import PlaceRequest
from engine.master.quotas import Quotas
from ppaas.errors import QuotaExceeded, Unavailable

MAX_QUEUED = 1000
MAX_QUEUED_OF_USER = 100
"""Largest number of queued requests, of all users and of one user."""

Open = Callable[[PlaceRequest], list[Order]]
"""Opens a place, or raises the reason why it cannot be opened now."""


class Queue:
    """Places that wait for room on a machine, or for their user's quota.

    First come, first served among those that fit. A large request that does not fit yet keeps its position and
    does not block smaller ones behind it.

    Parameters
    ----------
    quotas : Quotas
        Quotas of the users.
    """

    def __init__(self, quotas: Quotas) -> None:
        self._quotas = quotas
        self._requests: dict[str, PlaceRequest] = {}

    def __len__(self) -> int:
        """Return the number of queued requests."""
        return len(self._requests)

    def open(self, request: PlaceRequest, opening: Open) -> list[Order]:
        """Open a place now, or queue it.

        Raises
        ------
        QuotaExceeded
            The request exceeds its user's whole quota, or the queue is full.
        InvalidParameter
            As ``opening`` raises it.
        """
        try:
            return opening(request)
        except (QuotaExceeded, Unavailable):
            quota = self._quotas.of(request.user)
            if not quota.containers or quota.cores < request.cores:
                raise
        self._add(request)
        return []

    def _add(self, request: PlaceRequest) -> None:
        mine = sum(other.user == request.user for other in self._requests.values())
        if len(self._requests) >= MAX_QUEUED or mine >= MAX_QUEUED_OF_USER:
            raise QuotaExceeded(
                f"the queue is full: it holds {len(self._requests)} of at most {MAX_QUEUED} requests, {mine} of at "
                f"most {MAX_QUEUED_OF_USER} of user {request.user!r}: try again later"
            )
        self._requests[request.key] = request

    def serve(self, opening: Open) -> list[Order]:
        """Open all queued places that fit now, in order; return the orders."""
        orders: list[Order] = []
        full = FullMachines()
        for key, request in tuple(self._requests.items()):
            if full.refuse(request):
                continue
            try:
                orders += opening(request)
            except QuotaExceeded:
                continue
            except Unavailable:
                full.note(request)
                continue
            del self._requests[key]
        return orders

    def change(self, change: Callable[[PlaceRequest], PlaceRequest]) -> None:
        """Replace each request by the result of a function, which must not change its place."""
        self._requests = {key: change(request) for key, request in self._requests.items()}

    def get(self, key: str) -> PlaceRequest | None:
        """Return the queued request for a place, or None."""
        return self._requests.get(key)

    def remove(self, key: str) -> None:
        """Remove a place from the queue, if it is queued."""
        self._requests.pop(key, None)

    def position(self, key: str) -> int | None:
        """Return the position of a place, from 1; None if it is not queued."""
        return next((number for number, other in enumerate(self._requests, 1) if other == key), None)
