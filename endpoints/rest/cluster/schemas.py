"""The JSON of machines."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, StrictBool

from endpoints.rest.names import Name
from endpoints.rest.schemas import Number
from engine.specs.machine_settings import MAX_CONTAINERS, MOST_CONTAINERS, MOST_LABELS, MOST_OVERSUBSCRIPTION

MOST_MEMORY = 1 << 53
"""More than any machine has, and still a number that JavaScript tells from the next."""


class MachineChange(BaseModel):
    """What is to change of a machine (JSON merge patch): what is left out stays, and null stands for the default."""

    model_config = ConfigDict(extra="forbid")

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


class MachineAnswer(BaseModel):
    """A machine."""

    model_config = ConfigDict(from_attributes=True)

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
