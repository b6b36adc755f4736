"""A machine as the master sees it."""

from dataclasses import dataclass, field

from engine.control import ContainerLoad
from engine.cores import Sharing, capacity
from engine.model import ContainerSpec

MAX_CONTAINERS = 100

DECIMALS = 6
"""Sums of sizes are rounded to these, so that what comes and goes leaves no traces of a float."""


@dataclass(slots=True)
class Machine:
    """A machine and what is placed on it.

    Parameters
    ----------
    id : str
        Its name.
    cores : int
        CPUs it has.
    memory : int
        Bytes it has.
    pid : int
        Of its agent.
    sharing : {"shared", "dedicated"}
        How often each core is given out.
    max_containers : int
        Upper limit of containers.
    network : float
        Bytes that it can send and receive in a second; 0 where that is not known.
    cpu : float
        CPU in use, in cores.
    memory_used, network_used : float
        Bytes in use, and bytes sent and received in a second.
    round_trip : float
        To those that it serves and to other machines, on average [s].
    draining : bool
        It is given nothing new.
    given : float
        Sum of the sizes of its containers.
    """

    id: str
    cores: int
    memory: int
    pid: int
    sharing: Sharing = "shared"
    max_containers: int = MAX_CONTAINERS
    network: float = 0.0
    containers: dict[str, ContainerSpec] = field(default_factory=dict)
    cpu: float = 0.0
    memory_used: int = 0
    network_used: float = 0.0
    round_trip: float = 0.0
    draining: bool = False
    given: float = 0.0
    loads: dict[str, ContainerLoad] = field(default_factory=dict)

    @property
    def capacity(self) -> float:
        """Size it has to give, in cores."""
        return capacity(self.cores, self.sharing)

    @property
    def free(self) -> float:
        """Size it has left, in cores."""
        return self.capacity - self.given

    @property
    def room(self) -> float:
        """Size of the largest container that it takes now: of what is left, and of the CPUs that there are."""
        if self.draining or len(self.containers) >= self.max_containers:
            return 0.0
        return min(self.free, self.cores)

    def has_room(self, spec: ContainerSpec) -> bool:
        """Tell whether it takes a container."""
        return spec.cores <= self.room

    def place(self, spec: ContainerSpec) -> None:
        """Carry a container."""
        self.containers[spec.id] = spec
        self.given = round(self.given + spec.cores, DECIMALS)

    def remove(self, container: str) -> ContainerSpec | None:
        """Carry a container no more; return what it was, if it was here."""
        spec = self.containers.pop(container, None)
        if spec is not None:
            self.given = round(self.given - spec.cores, DECIMALS) if self.containers else 0.0
        return spec
