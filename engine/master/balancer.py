"""Interface of balancers, the plug-ins that choose machines for containers."""

from abc import ABC, abstractmethod
from typing import ClassVar

from engine.master.machine import Machine
from engine.specs.containers import ContainerSpec


class Balancer(ABC):
    """Chooses machines for containers.

    The master notifies it of every change, so that it can keep an index and need not examine every machine for each
    container. A subclass is found by an entry point in the group ``ppaas.balancers``, and takes its parameters as
    keyword arguments. Each method from ``joined`` to ``measured`` that it overrides must call the overridden one; here,
    all but ``joined`` and ``left`` do nothing. A balancer does not modify machines.

    Attributes
    ----------
    machines : dict of str to Machine
        All machines by name, in the order in which they registered.
    """

    name: ClassVar[str]
    purpose: ClassVar[str]

    def __init__(self) -> None:
        self.machines: dict[str, Machine] = {}

    @abstractmethod
    def choose(self, spec: ContainerSpec) -> Machine | None:
        """Return the machine for a container, or None if no machine has room."""

    def joined(self, machine: Machine) -> None:
        """Add a machine, which runs no containers yet."""
        self.machines[machine.id] = machine

    def left(self, machine: Machine) -> None:
        """Remove a machine, with all its containers."""
        del self.machines[machine.id]

    def placed(self, machine: Machine, spec: ContainerSpec) -> None:
        """Note that a container was placed on a machine."""

    def removed(self, machine: Machine, spec: ContainerSpec) -> None:
        """Note that a container was removed from a machine."""

    def timed(self, serves: str, machine_id: str, round_trip: float) -> None:
        """Note the measured round trip between a robot and a machine [s]."""

    def measured(self, machine: Machine) -> None:
        """Note that the load, the limits or the labels of a machine changed."""
