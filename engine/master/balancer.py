"""What a balancer is told and asked."""

from abc import ABC, abstractmethod
from typing import ClassVar

from engine.master.machine import Machine
from engine.specs.containers import ContainerSpec


class Balancer(ABC):
    """Chooses machines for containers. It is told of all that happens, so that it need not look at all to choose one.

    A subclass is found by an entry point in the group ``ppaas.balancers``, and takes its parameters as keyword
    arguments. What it overrides of ``joined`` … ``measured`` calls what it overrides; all but the first two do nothing
    here. It changes no machine.

    Attributes
    ----------
    machines : dict of str to Machine
        All there are, in the order in which they registered.
    """

    name: ClassVar[str]
    purpose: ClassVar[str]

    def __init__(self) -> None:
        self.machines: dict[str, Machine] = {}

    @abstractmethod
    def choose(self, spec: ContainerSpec) -> Machine | None:
        """Return the machine for a container, or None if none has room."""

    def joined(self, machine: Machine) -> None:
        """Learn of a machine, which carries nothing yet."""
        self.machines[machine.id] = machine

    def left(self, machine: Machine) -> None:
        """Learn that a machine is gone, with all that it carried."""
        del self.machines[machine.id]

    def placed(self, machine: Machine, spec: ContainerSpec) -> None:
        """Learn that a machine carries a container from now on."""

    def removed(self, machine: Machine, spec: ContainerSpec) -> None:
        """Learn that it carries it no more."""

    def timed(self, serves: str, machine_id: str, round_trip: float) -> None:
        """Learn how far a robot is from a machine, as a test of round trips between the two has shown [s]."""

    def measured(self, machine: Machine) -> None:
        """Learn that its load, or what it may be given, is another now."""
