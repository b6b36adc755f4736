"""Rapyuta's balancer: the first registered machine with enough free size (``rce-core``, ``MachineManager``)."""

from typing import ClassVar

from engine.master.balancer import Balancer
from engine.master.balancers.room_tree import RoomTree
from engine.master.machine import Machine
from engine.specs.containers import ContainerSpec


class FirstFit(Balancer):
    """Chooses the first machine with room."""

    name: ClassVar[str] = "first_fit"
    purpose: ClassVar[str] = "Rapyuta's: the first registered machine with enough free size."

    def __init__(self) -> None:
        super().__init__()
        self._tree = RoomTree()

    def choose(self, spec: ContainerSpec) -> Machine | None:
        """Return the first machine that has room for the container."""
        return self._tree.first(spec)

    def joined(self, machine: Machine) -> None:
        """Add a machine."""
        super().joined(machine)
        self._tree.put(machine)

    def left(self, machine: Machine) -> None:
        """Remove a machine."""
        super().left(machine)
        self._tree.remove(machine.id)

    def placed(self, machine: Machine, spec: ContainerSpec) -> None:
        """Update the room of a machine."""
        self._tree.put(machine)

    def removed(self, machine: Machine, spec: ContainerSpec) -> None:
        """Update the room of a machine."""
        self._tree.put(machine)

    def measured(self, machine: Machine) -> None:
        """Update the room of a machine."""
        self._tree.put(machine)
