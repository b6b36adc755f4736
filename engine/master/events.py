"""Events of the master.

They are immutable and complete: the master's state follows from them alone, so a log of them can be replayed. Times are
part of the events that need them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from engine.master.machine import UNKNOWN_SOFTWARE, Software
from engine.master.places import PlaceRequest
from engine.master.quotas import Quota
from engine.protocols.control_link import Heartbeat, RunningContainer
from engine.specs.containers import MapVersion
from engine.specs.machine_settings import MachineSettings
from ppaas.errors import PPaaSError
from storage.records import Limits

# -- requests of users -------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class PlaceRequested:
    """A user requests a place; with ``queue``, the request may wait for room or for the user's quota."""

    request: PlaceRequest
    queue: bool = False


@dataclass(frozen=True, slots=True)
class PlaceReleased:
    """A place is no longer needed."""

    place: str


@dataclass(frozen=True, slots=True)
class ResizeRequested:
    """A running container is to have another size [cores]; its place keeps the size while it is open."""

    container: str
    cores: float


@dataclass(frozen=True, slots=True)
class MapChanged:
    """A map has another current version; ``in_space`` is whether it has an octomap, None if that is not known.

    The clones that use this map, as map or mask, move to this version. ``number`` is the number of its publication: an
    event that arrives after one with a higher number is out of date.
    """

    map: MapVersion
    in_space: bool | None = False
    number: int = 0


@dataclass(frozen=True, slots=True)
class PlaceMoved:
    """A robot is on another map now, or was put elsewhere; the request for its place there."""

    request: PlaceRequest


@dataclass(frozen=True, slots=True)
class LimitsChanged:
    """A user has other limits than before."""

    user: str
    limits: Limits


@dataclass(frozen=True, slots=True)
class DefaultQuotaChanged:
    """Users without own limits have another quota than before."""

    quota: Quota


@dataclass(frozen=True, slots=True)
class ShutdownBegan:
    """The cloud is shutting down: queued places are not opened any more."""


# -- requests of administrators ----------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class SettingsLoaded:
    """Settings of machines and names of removed machines, as an earlier cloud process stored them."""

    settings: Mapping[str, MachineSettings]
    removed: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class SettingsChanged:
    """An administrator changed the settings of a machine."""

    machine: str
    settings: MachineSettings


@dataclass(frozen=True, slots=True)
class RemovalRequested:
    """An administrator removes a machine; with ``force``, also while it runs containers."""

    machine: str
    force: bool = False


@dataclass(frozen=True, slots=True)
class MachineAdmitted:
    """A removed machine may join again."""

    machine: str


# -- machines ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class MachinesExpected:
    """Machines of an earlier cloud process may reconnect, with the clones that they still run."""

    machines: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ReturnTimedOut:
    """The machines of an earlier cloud process that have not reconnected are no longer expected."""


@dataclass(frozen=True, slots=True)
class MachineJoined:
    """A machine registered.

    Parameters
    ----------
    machine : str
        Its name.
    cores : int
        Number of CPUs.
    memory : int
        Memory [bytes].
    pid : int
        Process id of its agent.
    labels : dict of str to str
        Labels that its agent reports.
    network : float
        Capacity of its network, sent and received [bytes/s]; 0 if unknown.
    carries : tuple of RunningContainer
        Containers of an earlier cloud process that are still the clones of their robots.
    software : Software
        Its release, and the protocol version of its link.
    """

    machine: str
    cores: int
    memory: int
    pid: int
    labels: Mapping[str, str] = field(default_factory=dict)
    network: float = 0.0
    carries: tuple[RunningContainer, ...] = ()
    software: Software = UNKNOWN_SOFTWARE


@dataclass(frozen=True, slots=True)
class MachineMeasured:
    """A machine reported its load."""

    machine: str
    load: Heartbeat


@dataclass(frozen=True, slots=True)
class MachineLeft:
    """The connection to a machine ended."""

    machine: str


# -- containers --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ContainerLaunched:
    """A machine started the process of a container."""

    machine: str
    container: str
    pid: int


@dataclass(frozen=True, slots=True)
class ContainerReady:
    """A container dialled the robot link; ``pid`` is its process id as it sees it."""

    container: str
    pid: int


@dataclass(frozen=True, slots=True)
class ContainerLost:
    """A container exited or could not be started.

    Parameters
    ----------
    container : str
    reason : PPaaSError
    now : float
        Time of the loss [monotonic s].
    machine : str
        Machine that reported it; empty if no machine did.
    """

    container: str
    reason: PPaaSError
    now: float
    machine: str = ""


@dataclass(frozen=True, slots=True)
class RobotTimed:
    """The round trip between the robot of a place and the machine that serves it was measured [s]."""

    place: str
    round_trip: float


UserRequest = (
    PlaceRequested
    | PlaceReleased
    | PlaceMoved
    | ResizeRequested
    | MapChanged
    | LimitsChanged
    | DefaultQuotaChanged
    | ShutdownBegan
)
AdministratorRequest = SettingsLoaded | SettingsChanged | RemovalRequested | MachineAdmitted
MachineReport = MachinesExpected | ReturnTimedOut | MachineJoined | MachineMeasured | MachineLeft
ContainerReport = ContainerLaunched | ContainerReady | ContainerLost | RobotTimed
Event = UserRequest | AdministratorRequest | MachineReport | ContainerReport
