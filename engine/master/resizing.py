"""Containers of another size: what is counted of them changes, and they run on."""

from msgspec.structs import replace

from engine.master.balancer import Balancer
from engine.master.machine import DECIMALS, Machine
from engine.master.orders import Resize
from engine.master.places import Place
from engine.master.quotas import Quotas
from engine.specs.cores import check as check_size
from ppaas.errors import Unavailable


def resize(place: Place, machine: Machine, cores: float, balancer: Balancer, quotas: Quotas) -> Resize:
    """Give the container of a place another size, and the next ones of this place too; return what is to be ordered.

    Parameters
    ----------
    place : Place
    machine : Machine
        That carries its container.
    cores : float
        The new size.
    balancer : Balancer
        Learns of it.
    quotas : Quotas
        Count it.

    Raises
    ------
    InvalidParameter
        The size is not a positive number.
    QuotaExceeded
        The user may not have so much more, or the machine has no so many cores.
    Unavailable
        The machine has no room for it, or the container is not ready.
    """
    before = place.spec
    if before is None or place.state != "ready" or place.leaving:
        raise Unavailable("the container starts or moves at this moment: try again when it is ready")
    check_size(cores, machine.cores)
    more = round(cores - before.cores, DECIMALS)
    if more > 0.0:
        quotas.check_cores(before.user, more)
    if more > max(machine.free, 0.0):
        raise Unavailable(f"machine {machine.id!r} has {max(machine.free, 0.0):g} cores left, and {more:g} are wanted")
    after = replace(before, cores=cores)
    machine.remove(before.id)
    balancer.removed(machine, before)
    machine.place(after)
    balancer.placed(machine, after)
    quotas.add(before.user, 0, more)
    place.spec, place.resized = after, cores
    return Resize(machine.id, after.id, cores)
