"""Builds the views of machines and containers from the state of the master and the place links."""

from engine.master.machine import Machine
from engine.master.places import Place
from engine.service.links.place_link import PlaceLink
from engine.service.views import ContainerView, MachineView
from engine.specs.cores import memory
from engine.specs.start_state import KernelProgress


def starting_view(machine: str, kernels: KernelProgress | None) -> MachineView:
    """Return the view of a machine that has not joined yet, and how far its kernels are."""
    return MachineView(
        id=machine, cores=0, capacity=0.0, containers=0, memory=0, memory_used=0, load=0.0, state="starting",
        kernels=kernels,
    )  # fmt: skip


def machine_view(machine: Machine, kernels: KernelProgress | None = None) -> MachineView:
    """Return the view of a machine, and of the kernels that it compiles."""
    settings = machine.settings
    return MachineView(
        id=machine.id,
        cores=machine.cores,
        capacity=machine.capacity,
        containers=len(machine.containers),
        memory=machine.memory,
        memory_used=machine.memory_used,
        load=machine.cpu,
        given=machine.given,
        memory_given=memory(machine.given),
        state=("drained" if not machine.containers else "draining") if settings.draining else "ready",
        labels=machine.all_labels,
        max_containers=settings.max_containers,
        max_memory=settings.max_memory,
        oversubscription=settings.oversubscription,
        draining=settings.draining,
        network=machine.network or None,
        network_used=machine.network_used,
        round_trip=machine.round_trip,
        round_trips=machine.neighbours,
        kernels=kernels,
    )


def container_view(
    place: Place,
    machine: Machine | None,
    link: PlaceLink | None,
    age: float,
    ready_seconds: float | None,
    *,
    connected: bool,
) -> ContainerView | None:
    """Return the view of a place's container; None if it has none.

    Parameters
    ----------
    place : Place
    machine : Machine, optional
        Machine of the container.
    link : PlaceLink, optional
        Link of the place.
    age : float
        Time since the order to start it [s].
    ready_seconds : float, optional
        Time from the order to its machine until it answered [s].
    connected : bool
        Whether its robot is connected.
    """
    spec = place.spec
    if spec is None:
        return None
    load = machine.loads.get(spec.id) if machine is not None else None
    return ContainerView(
        id=spec.id,
        kind=spec.kind,
        user=spec.user,
        robot=spec.robot.id if spec.robot is not None else None,
        map=spec.map,
        machine=place.machine or "",
        cores=spec.cores,
        state="ready" if place.state == "ready" else "starting",
        pid=place.pid,
        pss=load.pss if load is not None else None,
        ready_seconds=ready_seconds,
        cpu=load.cpu if load is not None else None,
        age=age,
        clients=link.clients if link is not None else 0,
        connected=connected,
        round_trip=link.beat.round_trip if link is not None else None,
        masks=tuple(mask.id for mask in spec.robot.masks.values()) if spec.robot is not None else (),
    )
