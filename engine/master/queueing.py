"""Requests that do not fit now: refused with a reason, or queued until they fit.

The balancer is not asked again for a size that no machine had room for.
"""

import math
from collections.abc import Callable, Collection, Mapping

from engine.master.machine import Machine
from engine.master.orders import Order
from engine.master.places import PlaceAssignment, PlaceRequest
from engine.master.quotas import Quotas
from engine.specs.cores import check as check_size
from engine.specs.machine_settings import labels_text
from ppaas.errors import QuotaExceeded, Unavailable

# -- containers that no machine has room for ---------------------------------------------------------------------------


class FullMachines:
    """Smallest size that no machine had room for, by required labels; valid until room becomes free."""

    def __init__(self) -> None:
        self._sizes: dict[frozenset[tuple[str, str]], float] = {}

    def note(self, wanted: PlaceAssignment | PlaceRequest) -> None:
        """Note that no machine has room for a container of a place or request."""
        self._sizes[_labels_of(wanted)] = wanted.cores

    def refuse(self, wanted: PlaceAssignment | PlaceRequest) -> bool:
        """Return whether no machine has room, because a container no larger found none among the same machines."""
        return bool(self._sizes) and wanted.cores >= self._sizes.get(_labels_of(wanted), math.inf)


def _labels_of(wanted: PlaceAssignment | PlaceRequest) -> frozenset[tuple[str, str]]:
    request = wanted.request if isinstance(wanted, PlaceAssignment) else wanted
    return frozenset(request.labels.items())


def check_fits(request: PlaceRequest, machines: Collection[Machine], quotas: Quotas) -> None:
    """Check that a place may be opened, whether or not a machine has room for it now.

    Raises
    ------
    InvalidParameter
        The size is not positive.
    QuotaExceeded
        The size exceeds the CPUs of every machine, or the user's quota of containers or cores.
    """
    # With thousands of machines, the largest is determined only to word a refusal.
    if machines and not any(0.0 < request.cores <= machine.cores for machine in machines):
        check_size(request.cores, max(machine.cores for machine in machines))
    quotas.check_container(request.user, request.cores)


def explain_no_machine(request: PlaceRequest, machines: Mapping[str, Machine]) -> str:
    """Return why none of the machines, at least one, accepts a request.

    If no machine has the requested labels, the text names the machine that has most of them, and those it lacks.
    """
    if not request.labels:  # the usual refusal of a full cloud: no machine is examined
        return _no_room("no machine", request)
    wanted = request.labels.items()
    missing = {machine.id: dict(wanted - machine.all_labels.items()) for machine in machines.values()}
    nearest = min(missing, key=lambda machine_id: len(missing[machine_id]))
    if missing[nearest]:
        lacks = labels_text(missing[nearest])
        return f"no machine has the labels {labels_text(request.labels)}; {nearest!r} is closest, but lacks {lacks}"
    return _no_room(f"no machine with labels {labels_text(request.labels)}", request)


def _no_room(machines: str, request: PlaceRequest) -> str:
    return f"{machines} has room for a container of {request.cores} cores: try again later"


# -- queue -------------------------------------------------------------------------------------------------------------

MAX_QUEUED = 1000

MAX_QUEUED_OF_USER = 100
"""Largest number of queued requests, of all users and of one user."""

Open = Callable[[PlaceRequest], list[Order]]
"""Opens a place, or raises the reason why it cannot be opened now."""


class PlaceQueue:
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
            # It would wait for ever.
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
