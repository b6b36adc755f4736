"""Containers that run since another cloud process, and the places that go on with them."""

import math

from msgspec.structs import replace

from engine.master.machine import Machine
from engine.master.places import Place, PlaceRequest
from engine.protocols.control_link import RunningContainer
from engine.specs.containers import ContainerSpec


def request_of(spec: ContainerSpec) -> PlaceRequest:
    """Return what the place is for that a container was started to fill."""
    return PlaceRequest(spec.user, spec.map, spec.cores, spec.robot, labels=spec.labels)


def may_adopt(place: Place | None, machine: Machine, carried: RunningContainer) -> bool:
    """Tell whether a place can go on with a container that a machine tells of.

    A place that nobody has asked for yet can. One that was asked for must be for the same robot on the same map, and
    have no other container, nor one to come: a robot has one clone. What only plans is not adopted: whoever waited for
    a path was told by the end of the connection.

    Parameters
    ----------
    place : Place, optional
        Of the name that the container says, if it is open.
    machine : Machine
        That carries it.
    carried : RunningContainer
        The container.
    """
    spec, cores = carried.spec, carried.cores
    if spec.robot is None or not (math.isfinite(cores) and 0.0 < cores <= machine.cores):
        return False
    if place is None:
        return True
    free = place.spec is None and place.successor is None
    return free and place.request == request_of(spec) and place.session in ("", spec.session)


def take_up(place: Place, machine: Machine, carried: RunningContainer) -> ContainerSpec:
    """Let a place go on with a container; return it as the machine is counted to carry it."""
    spec = replace(carried.spec, cores=carried.cores)
    machine.place(spec)
    place.spec, place.machine, place.state = spec, machine.id, "starting"
    place.pid, place.session = carried.pid, spec.session
    if carried.cores != carried.spec.cores:
        place.resized = carried.cores
    return spec
