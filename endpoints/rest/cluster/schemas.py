"""The JSON of machines, of containers, and of the health of the cloud."""

from typing import Annotated, Literal

from pydantic import BaseModel, Field, StrictBool

from endpoints.rest.names import Name
from endpoints.rest.schemas import Number, RequestBody, ResponseBody
from engine.specs.machine_settings import MAX_CONTAINERS, MOST_CONTAINERS, MOST_LABELS, MOST_OVERSUBSCRIPTION

MOST_MEMORY = 1 << 53
"""More than any machine has, and still a number that JavaScript tells from the next."""


class MachineChange(RequestBody):
    """What is to change of a machine (JSON merge patch): what is left out stays, and null stands for the default."""

    labels: Annotated[dict[Name, Name | None], Field(max_length=MOST_LABELS)] | None = Field(
        None, description="Some to be put or, with null, taken away; what the machine says of itself stays"
    )
    max_containers: Annotated[int, Field(strict=True, ge=0, le=MOST_CONTAINERS)] | None = Field(
        None, description=f"Upper limit of containers; {MAX_CONTAINERS} by default"
    )
    max_memory: Annotated[int, Field(strict=True, ge=1, le=MOST_MEMORY)] | None = Field(
        None, description="Upper limit of the bytes that it gives to containers; by default what it has"
    )
    oversubscription: Annotated[Number, Field(gt=0.0, le=MOST_OVERSUBSCRIPTION)] | None = Field(
        None, description="Cores that it gives away for each that it has"
    )
    draining: StrictBool | None = Field(
        None, description="Whether it is given nothing new, and what it carries is moved to other machines"
    )


class AdmittedMachine(BaseModel):
    """A machine that may come."""

    id: str


class MachineAnswer(ResponseBody):
    """A machine."""

    id: str
    state: Literal["ready", "draining", "drained"]
    cores: int
    capacity: float = Field(description="Size it may give to containers, in cores")
    given: float = Field(description="Sum of the sizes of its containers, in cores")
    containers: int
    load: float = Field(description="CPU in use, in cores")
    memory: int = Field(description="Bytes")
    memory_given: int = Field(description="Bytes that its containers count for")
    memory_used: int = Field(description="Bytes")
    labels: dict[str, str]
    max_containers: int
    max_memory: int | None
    oversubscription: float
    draining: bool
    network: float | None = Field(description="What it can send and receive in a second [bytes], where it is known")
    network_used: float = Field(description="What it sends and receives in a second [bytes]")
    round_trip: float = Field(description="To the robots that it serves and to other machines, on average [s]")
    round_trips: dict[str, float] = Field(description="To other machines [s]")


class PinnedMap(ResponseBody):
    """A map, and the version of it that a container has."""

    id: str
    version: str


class ContainerAnswer(ResponseBody):
    """A container."""

    id: str
    kind: Literal["robot", "planning"]
    user: str
    robot: str | None
    map: PinnedMap
    machine: str
    cores: float
    state: Literal["starting", "ready"]
    pid: int | None
    pss: int | None = Field(description="Proportional set size [bytes]")
    ready_seconds: float | None = Field(description="From the order to start it until it answered [s]")
    cpu: float | None = Field(description="CPU in use, in cores, once it was measured")
    age: float = Field(description="Since the order to start it [s]")
    clients: int = Field(description="Sockets of the robot and its operators")
    round_trip: float | None = Field(description="To the robot, once it was measured [s]")


class StoreHealth(ResponseBody):
    """Whether a store answers."""

    state: Literal["ok", "away"]
    reason: str | None = Field(description="Why it does not, for administrators")


class HealthAnswer(ResponseBody):
    """How the cloud does."""

    status: Literal["ok", "degraded"]
    store: StoreHealth = Field(description="Of all but maps")
    map_store: StoreHealth
    plans_waiting: int = Field(description="Paths that wait on the disk for the store to come back")
