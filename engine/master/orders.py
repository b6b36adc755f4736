"""Orders of the master."""

from dataclasses import dataclass

from engine.protocols.control_link import RunningContainer
from engine.specs.containers import ContainerSpec
from ppaas.errors import PPaaSError


@dataclass(frozen=True, slots=True)
class Start:
    """Order: start a container on a machine after ``delay`` [s], from the last checkpoint of its session."""

    place: str
    machine: str
    spec: ContainerSpec
    delay: float = 0.0


@dataclass(frozen=True, slots=True)
class Adopt:
    """Order: adopt a container that a machine runs since an earlier cloud process."""

    place: str
    machine: str
    carried: RunningContainer


@dataclass(frozen=True, slots=True)
class End:
    """Order: end a container."""

    machine: str
    container: str


@dataclass(frozen=True, slots=True)
class Leave:
    """Order: make a container store its state and end; its successor then starts on another machine."""

    place: str
    machine: str
    container: str


@dataclass(frozen=True, slots=True)
class Resize:
    """Order: change the size of a running container [cores]."""

    machine: str
    container: str
    cores: float


@dataclass(frozen=True, slots=True)
class UseMap:
    """Order: let the clone in a container go on with the versions of map and masks in its spec."""

    machine: str
    spec: ContainerSpec


@dataclass(frozen=True, slots=True)
class Close:
    """Order: close a place, and notify its clients of the reason."""

    place: str
    reason: PPaaSError


Order = Start | Adopt | End | Leave | Resize | UseMap | Close
