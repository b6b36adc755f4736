"""A machine as the master sees it."""

from dataclasses import dataclass, field

from engine.control import ContainerLoad
from engine.cores import Sharing, capacity
from engine.model import ContainerSpec

MAX_CONTAINERS = 100


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
    """

    id: str
    cores: int
    memory: int
    pid: int
    sharing: Sharing = "shared"
    max_containers: int = MAX_CONTAINERS
    containers: dict[str, ContainerSpec] = field(default_factory=dict)
    cpu: float = 0.0
    memory_used: int = 0
    loads: dict[str, ContainerLoad] = field(default_factory=dict)

    @property
    def capacity(self) -> float:
        """Size it has to give, in cores."""
        return capacity(self.cores, self.sharing)

    @property
    def free(self) -> float:
        """Size it has left, in cores."""
        return self.capacity - sum(spec.cores for spec in self.containers.values())

    def has_room(self, spec: ContainerSpec) -> bool:
        """Tell whether a container fits: into what is left, and into the CPUs that there are."""
        fits = spec.cores <= min(self.free, self.cores)
        return fits and len(self.containers) < self.max_containers
