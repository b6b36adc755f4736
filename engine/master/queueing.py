"""The queue of those who would rather wait than be refused."""

import math
from collections.abc import Callable

from engine.master.orders import Order
from engine.master.places import PlaceRequest
from engine.master.quotas import Quotas
from ppaas.errors import QuotaExceeded, Unavailable

MAX_QUEUED = 1000
MAX_QUEUED_OF_USER = 100

Open = Callable[[PlaceRequest], list[Order]]
"""Opens a place, or raises why it cannot be now."""


class Queue:
    """Places that wait for room, or for what their user's quota has left.

    First come, first served, within what fits: a large one that does not fit yet keeps its position and no small one
    from being served.

    Parameters
    ----------
    quotas : Quotas
        What users may have.
    """

    def __init__(self, quotas: Quotas) -> None:
        self._quotas = quotas
        self._requests: dict[str, PlaceRequest] = {}

    def open(self, request: PlaceRequest, opening: Open) -> list[Order]:
        """Open a place now, or let it wait for its turn.

        Raises
        ------
        QuotaExceeded
            Its user may never have it, or there are too many who wait.
        InvalidParameter
            As ``opening`` says.
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
                f"{len(self._requests)} wait already, {mine} of them of user {request.user!r}; the queue holds "
                f"{MAX_QUEUED}, and {MAX_QUEUED_OF_USER} of one user: try again later"
            )
        self._requests[request.key] = request

    def serve(self, opening: Open) -> list[Order]:
        """Open all places that fit now, in their order; return what is to be ordered."""
        orders: list[Order] = []
        too_large: dict[frozenset[tuple[str, str]], float] = {}
        for key, request in tuple(self._requests.items()):
            labels = frozenset(request.labels.items())
            if request.cores >= too_large.get(labels, math.inf):
                continue
            try:
                orders += opening(request)
            except QuotaExceeded:
                continue
            except Unavailable:
                too_large[labels] = request.cores
                continue
            del self._requests[key]
        return orders

    def get(self, key: str) -> PlaceRequest | None:
        """Return who waits, or None."""
        return self._requests.get(key)

    def remove(self, key: str) -> None:
        """Let a place wait no more, if it does."""
        self._requests.pop(key, None)

    def position(self, key: str) -> int | None:
        """Return the position of a place, the first being 1; None if it does not wait."""
        return next((number for number, other in enumerate(self._requests, 1) if other == key), None)
