"""What the master orders."""

from dataclasses import dataclass

from engine.protocols.control_link import RunningContainer
from engine.specs.containers import ContainerSpec
from ppaas.errors import PPaaSError


@dataclass(frozen=True, slots=True)
class Start:
    """Order: start this container on this machine after some seconds, from the last checkpoint of its session."""

    place: str
    machine: str
    spec: ContainerSpec
    delay: float = 0.0


@dataclass(frozen=True, slots=True)
class Adopt:
    """Order: let a place go on with this container, which a machine carries since another cloud process."""

    place: str
    machine: str
    carried: RunningContainer


@dataclass(frozen=True, slots=True)
class End:
    """Order: end this container."""

    machine: str
    container: str


@dataclass(frozen=True, slots=True)
class Leave:
    """Order: have this container keep its state and end; when it is gone, another goes on elsewhere."""

    place: str
    machine: str
    container: str


@dataclass(frozen=True, slots=True)
class Resize:
    """Order: hold this container to another size [cores] while it runs."""

    machine: str
    container: str
    cores: float


@dataclass(frozen=True, slots=True)
class Close:
    """Order: tell whoever uses the place that it is no more, and why."""

    place: str
    reason: PPaaSError


Order = Start | Adopt | End | Leave | Resize | Close
