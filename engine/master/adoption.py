"""Adoption: places take over containers that an earlier cloud process started."""

import math

from msgspec.structs import replace

from engine.master.machine import Machine
from engine.master.places import Place, PlaceRequest
from engine.protocols.control_link import RunningContainer
from engine.specs.containers import ContainerSpec


def request_of(spec: ContainerSpec) -> PlaceRequest:
    """Return the request for the place that a container was started to fill."""
    return PlaceRequest(spec.user, spec.map, spec.cores, spec.robot, labels=spec.labels, group_node=spec.group_node)


def may_adopt(place: Place | None, machine: Machine, carried: RunningContainer) -> bool:
    """Return whether a place may adopt a container that a machine reported.

    A place that is not open yet may. An open place must be for the same robot or group on the same map, and have
    neither another container nor a successor, since a robot has one clone. Containers that only plan are not adopted:
    the connections of the clients that waited for their paths ended with the earlier cloud process.

    Parameters
    ----------
    place : Place, optional
        Place that the container fills; None if it is not open.
    machine : Machine
        Machine that runs the container.
    carried : RunningContainer
        The container as its machine reported it.
    """
    spec, cores = carried.spec, carried.cores
    if spec.kind == "planning" or not (math.isfinite(cores) and 0.0 < cores <= machine.cores):
        return False
    if place is None:
        return True
    free = place.spec is None and place.successor is None
    return free and place.request == request_of(spec) and place.session in ("", spec.session)


def take_up(place: Place, machine: Machine, carried: RunningContainer) -> ContainerSpec:
    """Assign a running container to a place and count it on its machine; return its spec with its current size."""
    spec = replace(carried.spec, cores=carried.cores)
    machine.place(spec)
    place.spec, place.machine, place.state = spec, machine.id, "starting"
    place.pid, place.session = carried.pid, spec.session
    if carried.cores != carried.spec.cores:
        place.resized = carried.cores
    return spec
