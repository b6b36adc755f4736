"""JSON schemas of machines, endpoints and containers, and of the cloud's health."""

from typing import Annotated, Literal

from pydantic import BaseModel, Field, StrictBool

from endpoints.rest.names import Name
from endpoints.rest.schemas import Number, RequestBody, ResponseBody
from engine.specs.machine_settings import MAX_CONTAINERS, MOST_CONTAINERS, MOST_LABELS, MOST_OVERSUBSCRIPTION
from storage.disk_space import SpaceState

MAX_MEMORY = 1 << 53
"""Largest memory limit [bytes]: the largest integer that JavaScript represents exactly."""


class MachineChange(RequestBody):
    """Changes of a machine (JSON merge patch): omitted fields stay unchanged, null restores the default."""

    labels: Annotated[dict[Name, Name | None], Field(max_length=MOST_LABELS)] | None = Field(
        None, description="Labels to set or, with null, to remove; labels that the machine reports itself stay"
    )
    max_containers: Annotated[int, Field(strict=True, ge=0, le=MOST_CONTAINERS)] | None = Field(
        None, description=f"Upper limit of containers; {MAX_CONTAINERS} by default"
    )
    max_memory: Annotated[int, Field(strict=True, ge=1, le=MAX_MEMORY)] | None = Field(
        None, description="Upper limit of the memory for containers [bytes]; by default all memory of the machine"
    )
    oversubscription: Annotated[Number, Field(gt=0.0, le=MOST_OVERSUBSCRIPTION)] | None = Field(
        None, description="Cores given to containers per core of the machine"
    )
    draining: StrictBool | None = Field(
        None, description="Whether it gets no new containers and its clones move to other machines"
    )


class AdmittedMachine(BaseModel):
    """Machine that may join."""

    id: str


class KernelHealth(ResponseBody):
    """Kernels that a machine of the cloud compiles now."""

    done: int = Field(description="Number of kernel modules that are compiled")
    total: int = Field(description="Number of all kernel modules")
    compiling: list[str] = Field(description="Some that are being compiled, such as `lattice/hybrid_astar`")


class MachineAnswer(ResponseBody):
    """Machine of the cloud."""

    id: str
    state: Literal["starting", "ready", "draining", "drained"] = Field(
        description="`starting` while it has not joined yet, since it compiles kernels: its other numbers are 0 then"
    )
    cores: int
    capacity: float = Field(description="Total size of containers it may run [cores]")
    given: float = Field(description="Total size of its containers [cores]")
    containers: int
    load: float = Field(description="CPU in use [cores]")
    memory: int = Field(description="Memory of the machine [bytes]")
    memory_given: int = Field(description="Memory reserved for its containers [bytes]")
    memory_used: int = Field(description="Memory in use [bytes]")
    labels: dict[str, str]
    max_containers: int
    max_memory: int | None
    oversubscription: float
    draining: bool
    network: float | None = Field(description="Capacity of its network [bytes/s], if known")
    network_used: float = Field(description="Network traffic, sent and received [bytes/s]")
    round_trip: float = Field(description="Mean round trip to its robots and to other machines [s]")
    round_trips: dict[str, float] = Field(description="Round trips to other machines [s]")
    kernels: KernelHealth | None = Field(description="Kernels that it compiles now; null once all are compiled")
    release: str = Field(description="Version of ppaas; empty while it has not joined yet")
    protocol: int = Field(description="Version of the protocol on its link to the master")


class EndpointAnswer(ResponseBody):
    """Endpoint of the cloud."""

    id: str
    machine: str = Field(description="Machine on which it runs")
    pid: int = Field(description="Process id there")
    url: str = Field(description="Address at which it serves")
    release: str = Field(description="Version of ppaas")
    state: Literal["ready", "silent"] = Field(
        description="`silent` if it is connected to the master, but has not reported its load for a while"
    )
    sockets: int = Field(description="Number of sockets of robots and operators")
    frames: float = Field(description="Frames that clients sent [1/s]")
    cpu: float = Field(description="CPU in use [cores]")
    memory: int = Field(description="Memory in use [bytes]")
    protocol: int = Field(description="Version of the protocol on its link to the master")


class PinnedMap(ResponseBody):
    """Map version that a container uses."""

    id: str
    version: str


class ContainerAnswer(ResponseBody):
    """Container of a robot, for planning, or with the people coordinator or the traffic node of robots on a map."""

    id: str
    kind: Literal["robot", "planning", "coordinator", "traffic"]
    user: str
    robot: str | None
    map: PinnedMap
    machine: str
    cores: float
    state: Literal["starting", "ready"]
    pid: int | None
    pss: int | None = Field(description="Proportional set size [bytes]")
    ready_seconds: float | None = Field(description="Time from the order to start it until it was ready [s]")
    cpu: float | None = Field(description="CPU in use [cores], once measured")
    age: float = Field(description="Time since the order to start it [s]")
    clients: int = Field(description="Number of sockets of the robot and its operators")
    connected: bool = Field(
        description="Whether the robot is connected: one of them is its own. A container waits for a robot that left"
    )
    round_trip: float | None = Field(description="Round trip to the robot [s], once measured")


class StoreHealth(ResponseBody):
    """State of a store, or of the audit log."""

    state: Literal["ok", "away"]
    reason: str | None = Field(description="Reason of the failure, for administrators")


class DiskHealth(ResponseBody):
    """Space on the disk of the data folder."""

    state: SpaceState = Field(description="While it is full, nothing new is stored")
    reason: str | None = Field(description="Reason why it is low or full, with advice; null if it is ok")
    free: int = Field(description="Free space [bytes]")
    total: int = Field(description="Size of the disk [bytes]")


class LeaderHealth(ResponseBody):
    """Process that leads the cloud."""

    holder: str = Field(description="Its name: host, data folder, and a number")
    epoch: int = Field(description="Number of times that a process has taken the lead")


class ReadyAnswer(ResponseBody):
    """Answer of an endpoint that may get new connections."""

    ready: Literal[True]


class HealthAnswer(ResponseBody):
    """Health of the cloud."""

    status: Literal["ok", "starting", "degraded"] = Field(
        description="`starting` while no machine can start containers; `degraded` while something is away or full"
    )
    endpoint: str = Field(description="Name of the endpoint that answers")
    master: Literal["ok", "away"] = Field(description="Whether the master answers this endpoint")
    leader: LeaderHealth | None = Field(description="Process that holds the lease of the master, for administrators")
    kernels: KernelHealth | None = Field(
        description="Progress of the first start on a computer, which compiles kernels; null once all are compiled"
    )
    version: str = Field(description="Version of ppaas")
    time: float = Field(description="Clock of the cloud [s since the epoch], for robots whose clock may be wrong")
    store: StoreHealth = Field(description="Store of everything but maps")
    map_store: StoreHealth
    audit: StoreHealth = Field(description="Audit log; while it is away, its events wait in memory")
    plans_waiting: int = Field(description="Number of paths that wait on the disk for the store")
    disk: DiskHealth | None = Field(description="Disk of the data folder, for administrators")
