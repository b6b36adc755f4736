"""Explains to the user why no machine has room for a container."""

from collections.abc import Collection, Mapping

from engine.master.machine import Machine
from engine.master.places import PlaceRequest
from engine.master.quotas import Quotas
from engine.specs.cores import check as check_size
from engine.specs.machine_settings import labels_text


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
