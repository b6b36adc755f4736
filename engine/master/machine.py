"""A machine as the master sees it."""

from dataclasses import dataclass, field

from engine.protocols.control_link import ContainerLoad
from engine.specs.containers import ContainerSpec
from engine.specs.cores import capacity
from engine.specs.machine_settings import MachineSettings

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
    labels : dict of str to str
        What it is like, as its agent says.
    settings : MachineSettings
        What an administrator says of it.
    network : float
        Bytes that it can send and receive in a second; 0 where that is not known.
    cpu : float
        CPU in use, in cores.
    memory_used, network_used : float
        Bytes in use, and bytes sent and received in a second.
    round_trip : float
        To those that it serves and to other machines, on average [s].
    neighbours, served : dict of str to float
        Round trips to other machines, by their names, and to the robots of its containers [s].
    given : float
        Sum of the sizes of its containers.
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

    @property
    def all_labels(self) -> dict[str, str]:
        """What it is like; what an administrator says goes first."""
        return self.labels | self.settings.labels

    @property
    def capacity(self) -> float:
        """Size it has to give, in cores."""
        limit = self.settings.max_memory
        memory = self.memory if limit is None else min(self.memory, limit)
        return capacity(self.cores, memory, self.settings.oversubscription)

    @property
    def free(self) -> float:
        """Size it has left, in cores."""
        return self.capacity - self.given

    @property
    def room(self) -> float:
        """Size of the largest container that it takes now: of what is left, and of the CPUs that there are."""
        if self.settings.draining or len(self.containers) >= self.settings.max_containers:
            return 0.0
        return min(self.free, self.cores)

    def has_room(self, spec: ContainerSpec) -> bool:
        """Tell whether it takes a container: it has the room, and the labels that are asked for."""
        return spec.cores <= self.room and self.suits(spec.labels)

    def suits(self, labels: dict[str, str]) -> bool:
        """Tell whether it has these labels."""
        return not labels or labels.items() <= self.all_labels.items()

    def place(self, spec: ContainerSpec) -> None:
        """Carry a container."""
        self.containers[spec.id] = spec
        self.given = round(self.given + spec.cores, DECIMALS)

    def average_round_trips(self) -> None:
        """Take what was measured to others, and to whom it serves, into its round trip."""
        known = (*self.neighbours.values(), *self.served.values())
        self.round_trip = sum(known) / len(known) if known else 0.0

    def remove(self, container: str) -> ContainerSpec | None:
        """Carry a container no more; return what it was, if it was here."""
        spec = self.containers.pop(container, None)
        self.served.pop(container, None)
        if spec is not None:
            self.given = round(self.given - spec.cores, DECIMALS) if self.containers else 0.0
        return spec
