"""Machines and containers, as the engine shows them to the endpoints."""

from typing import Literal

import msgspec

from engine.specs.containers import ContainerKind, MapVersion
from engine.specs.cores import OVERSUBSCRIPTION
from engine.specs.machine_settings import MAX_CONTAINERS

ContainerState = Literal["starting", "ready"]
MachineState = Literal["ready", "draining", "drained"]


class MachineView(msgspec.Struct, frozen=True):
    """A machine.

    Parameters
    ----------
    cores : int
        CPUs it has.
    capacity : float
        Size it may give to containers, in cores: by its CPUs, the oversubscription and its memory.
    containers : int
        How many are placed on it.
    memory, memory_used : int
        Bytes.
    load : float
        CPU in use, in cores.
    given : float
        Sum of the sizes of its containers, in cores.
    memory_given : int
        Bytes that these count for.
    state : {"ready", "draining", "drained"}
        Whether it is given containers, or its own are moved to others, or that is done.
    labels : dict of str to str
        What it is like.
    max_containers : int
        Upper limit of containers.
    max_memory : int, optional
        Upper limit of the bytes that it may give; without it, what it has.
    oversubscription : float
        Cores that it gives away for each that it has.
    draining : bool
        Whether an administrator drains it.
    network : float, optional
        What it can send and receive in a second [bytes], where that is known.
    network_used : float
        What it sends and receives in a second [bytes].
    round_trip : float
        To the robots that it serves and to other machines, on average [s].
    round_trips : dict of str to float
        To other machines, by their names [s].
    """

    id: str
    cores: int
    capacity: float
    containers: int
    memory: int
    memory_used: int
    load: float
    given: float = 0.0
    memory_given: int = 0
    state: MachineState = "ready"
    labels: dict[str, str] = {}
    max_containers: int = MAX_CONTAINERS
    max_memory: int | None = None
    oversubscription: float = OVERSUBSCRIPTION
    draining: bool = False
    network: float | None = None
    network_used: float = 0.0
    round_trip: float = 0.0
    round_trips: dict[str, float] = {}


class ContainerView(msgspec.Struct, frozen=True):
    """A container.

    Parameters
    ----------
    robot : str, optional
        The robot whose clone runs in it; without one it only plans.
    cores : float
        Its size.
    pid : int, optional
        Of its process, once it runs.
    pss : int, optional
        Proportional set size [bytes], once it was measured.
    ready_seconds : float, optional
        From the order to start it until it answered [s].
    cpu : float, optional
        CPU in use, in cores, once it was measured.
    age : float
        Since the order to start it [s].
    clients : int
        Sockets of the robot and its operators.
    round_trip : float, optional
        To the robot, once it was measured [s].
    masks : tuple of str
        Ids of the maps that its costmap filters go by.
    """

    id: str
    kind: ContainerKind
    user: str
    robot: str | None
    map: MapVersion
    machine: str
    cores: float
    state: ContainerState
    pid: int | None = None
    pss: int | None = None
    ready_seconds: float | None = None
    cpu: float | None = None
    age: float = 0.0
    clients: int = 0
    round_trip: float | None = None
    masks: tuple[str, ...] = ()
