"""Machine, as the master sees it."""

from dataclasses import dataclass, field
from typing import NamedTuple

from engine.protocols.control_link import ContainerLoad
from engine.specs.containers import ContainerSpec
from engine.specs.cores import capacity
from engine.specs.machine_settings import MachineSettings

DECIMALS = 6
"""Decimals to which sums of sizes are rounded, so that no floating-point residue accumulates."""


class Software(NamedTuple):
    """Software of a machine: its release, and the protocol version of its link to the master."""

    release: str = ""
    protocol: int = 0


UNKNOWN_SOFTWARE = Software()


@dataclass(slots=True)
class Machine:
    """A machine and the containers placed on it.

    Parameters
    ----------
    id : str
        Its name.
    cores : int
        Number of CPUs.
    memory : int
        Memory [bytes].
    pid : int
        Process id of its agent.
    labels : dict of str to str
        Labels that its agent reports.
    settings : MachineSettings
        Settings by an administrator.
    network : float
        Capacity of its network, sent and received [bytes/s]; 0 if unknown.
    containers : dict of str to ContainerSpec
        Containers placed on it, by id.
    cpu : float
        CPU in use [cores].
    memory_used : int
        Memory in use [bytes].
    network_used : float
        Data sent and received [bytes/s].
    round_trip : float
        Average round trip to the robots that it serves and to other machines [s].
    neighbours, served : dict of str to float
        Round trips to other machines, by name, and to the robots of its containers, by container id [s].
    given : float
        Sum of the sizes of its containers [cores].
    loads : dict of str to ContainerLoad
        Last reported load of each container, by id.
    software : Software
        Its release, and the protocol version of its link.
    """

    id: str
    cores: int
    memory: int
    pid: int
    labels: dict[str, str] = field(default_factory=dict)
    settings: MachineSettings = field(default_factory=MachineSettings)
    network: float = 0.0
    containers: dict[str, ContainerSpec] = field(default_factory=dict)
    cpu: float = 0.0
    memory_used: int = 0
    network_used: float = 0.0
    round_trip: float = 0.0
    neighbours: dict[str, float] = field(default_factory=dict)
    served: dict[str, float] = field(default_factory=dict)
    given: float = 0.0
    loads: dict[str, ContainerLoad] = field(default_factory=dict)
    software: Software = UNKNOWN_SOFTWARE

    @property
    def all_labels(self) -> dict[str, str]:
        """Labels of the agent and of the administrator, who takes precedence."""
        return self.labels | self.settings.labels

    @property
    def capacity(self) -> float:
        """Total size that it may give to containers [cores]."""
        limit = self.settings.max_memory
        memory = self.memory if limit is None else min(self.memory, limit)
        return capacity(self.cores, memory, self.settings.oversubscription)

    @property
    def free(self) -> float:
        """Size that is not given to containers [cores]; negative after a limit was lowered below what is given."""
        return self.capacity - self.given

    @property
    def room(self) -> float:
        """Size of the largest container that it accepts now [cores]: at most the free size, and at most its CPUs."""
        if self.settings.draining or len(self.containers) >= self.settings.max_containers:
            return 0.0
        return min(self.free, self.cores)

    def has_room(self, spec: ContainerSpec) -> bool:
        """Return whether it has room for a container, and the labels that the container requires."""
        return spec.cores <= self.room and self.suits(spec.labels)

    def suits(self, labels: dict[str, str]) -> bool:
        """Return whether it has these labels."""
        return not labels or labels.items() <= self.all_labels.items()

    def place(self, spec: ContainerSpec) -> None:
        """Add a container."""
        self.containers[spec.id] = spec
        self.given = round(self.given + spec.cores, DECIMALS)

    def average_round_trips(self) -> None:
        """Update ``round_trip`` from the round trips to other machines and to robots."""
        known = (*self.neighbours.values(), *self.served.values())
        self.round_trip = sum(known) / len(known) if known else 0.0

    def remove(self, container: str) -> ContainerSpec | None:
        """Remove a container; return its spec, or None if it was not here."""
        spec = self.containers.pop(container, None)
        self.served.pop(container, None)
        if spec is not None:
            self.given = round(self.given - spec.cores, DECIMALS) if self.containers else 0.0
        return spec
