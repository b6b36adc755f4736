"""Changes the size of running containers."""

from msgspec.structs import replace

from engine.master.balancer import Balancer
from engine.master.machine import DECIMALS, Machine
from engine.master.orders import Resize
from engine.master.places import Place
from engine.master.quotas import Quotas
from engine.specs.cores import check as check_size
from ppaas.errors import Unavailable


def resize(place: Place, machine: Machine, cores: float, balancer: Balancer, quotas: Quotas) -> Resize:
    """Change the size of a place's container and of its later containers; return the order.

    Parameters
    ----------
    place : Place
    machine : Machine
        Machine of its container.
    cores : float
        New size [cores].
    balancer : Balancer
        Balancer to notify.
    quotas : Quotas
        Quotas, where the new size is counted.

    Raises
    ------
    InvalidParameter
        The size is not a positive number.
    QuotaExceeded
        The size exceeds the user's quota, or the CPUs of the machine.
    Unavailable
        The machine has no room for it, or the container is not ready.
    """
    before = place.spec
    if before is None or place.state != "ready" or place.leaving:
        raise Unavailable("the container is starting or moving: try again when it is ready")
    check_size(cores, machine.cores)
    more = round(cores - before.cores, DECIMALS)
    if more > 0.0:
        quotas.check_cores(before.user, more)
    if more > max(machine.free, 0.0):
        raise Unavailable(
            f"machine {machine.id!r} has {max(machine.free, 0.0):g} free cores, but {more:g} more are needed"
        )
    after = replace(before, cores=cores)
    machine.remove(before.id)
    balancer.removed(machine, before)
    machine.place(after)
    balancer.placed(machine, after)
    quotas.add(before.user, 0, more)
    place.spec, place.resized = after, cores
    return Resize(machine.id, after.id, cores)
