"""Why no machine takes a container, in words for whoever asked for it."""

from collections.abc import Collection, Mapping

from engine.master.machine import Machine
from engine.master.places import PlaceRequest
from engine.master.quotas import Quotas
from engine.specs.cores import check as check_size
from engine.specs.machine_settings import labels_text


def check_fits(request: PlaceRequest, machines: Collection[Machine], quotas: Quotas) -> None:
    """Make sure that a place may be opened, whether or not a machine has room for it now.

    Raises
    ------
    InvalidParameter
        A size that is not positive, or larger than any machine.
    QuotaExceeded
        The user has too many containers or cores.
    """
    # Among thousands of machines the largest is looked for only where there is something to refuse.
    if machines and not any(0.0 < request.cores <= machine.cores for machine in machines):
        check_size(request.cores, max(machine.cores for machine in machines))
    quotas.check_container(request.user, request.cores)


def why_none(request: PlaceRequest, machines: Mapping[str, Machine]) -> str:
    """Return why none of the machines, of which there is one at least, takes what is asked for.

    Where none has the labels, the machine that fits best is named with what it lacks.
    """
    wanted = request.labels.items()
    missing = {machine.id: dict(wanted - machine.all_labels.items()) for machine in machines.values()}
    nearest = min(missing, key=lambda machine_id: len(missing[machine_id]))
    if missing[nearest]:
        lacks = labels_text(missing[nearest])
        return f"no machine is labelled {labels_text(request.labels)}; {nearest!r} fits best, and lacks {lacks}"
    such = f" labelled {labels_text(request.labels)}" if request.labels else ""
    return f"no machine{such} has room for a container of {request.cores} cores: try again later"
