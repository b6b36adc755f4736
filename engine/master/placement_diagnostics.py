"""Containers that no machine has room for: refused without asking the balancer again, and explained to the user."""

import math
from collections.abc import Collection, Mapping

from engine.master.machine import Machine
from engine.master.places import Place, PlaceRequest
from engine.master.quotas import Quotas
from engine.specs.cores import check as check_size
from engine.specs.machine_settings import labels_text


class FullMachines:
    """Smallest size that no machine had room for, by required labels; valid until room becomes free."""

    def __init__(self) -> None:
        self._sizes: dict[frozenset[tuple[str, str]], float] = {}

    def note(self, wanted: Place | PlaceRequest) -> None:
        """Note that no machine has room for a container of a place or request."""
        self._sizes[_labels_of(wanted)] = wanted.cores

    def refuse(self, wanted: Place | PlaceRequest) -> bool:
        """Return whether no machine has room, because a container no larger found none among the same machines."""
        return bool(self._sizes) and wanted.cores >= self._sizes.get(_labels_of(wanted), math.inf)


def _labels_of(wanted: Place | PlaceRequest) -> frozenset[tuple[str, str]]:
    request = wanted.request if isinstance(wanted, Place) else wanted
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
