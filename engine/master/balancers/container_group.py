"""Machines of a container group, searched for the one with most of its containers that has room for another."""

from dataclasses import dataclass, field

from engine.master.balancers.room_tree import RoomTree
from engine.master.machine import Machine
from engine.specs.containers import ContainerSpec

FEW = 8
"""Number of machines up to which each is examined; a tree of more finds one in less time."""

LATER = 2.0**-40
"""Difference between the scores of machines with equally many containers: the one that had the first is preferred."""


@dataclass(slots=True)
class ContainerGroup:
    """Numbers of a group's containers on the machines that have any.

    The room in the tree of a large group may be out of date. It is at least the actual room, provided that ``update``
    is called when the room of a machine has grown.
    """

    _members: dict[str, tuple[Machine, int, int]] = field(default_factory=dict)
    _joined: int = 0
    _tree: RoomTree | None = None

    def __bool__(self) -> bool:
        """Return whether the group has any containers."""
        return bool(self._members)

    def add(self, machine: Machine, count: int) -> bool:
        """Add ``count`` containers to a machine, or remove some if negative; return whether it has any now."""
        _, before, number = self._members.get(machine.id, (machine, 0, self._joined))
        if not before:
            self._joined += 1
        if before + count:
            self._members[machine.id] = machine, before + count, number
            self._index(machine)
        else:
            self.remove(machine.id)
        return bool(before + count)

    def remove(self, machine_id: str) -> None:
        """Remove a machine."""
        del self._members[machine_id]
        if self._tree is not None:
            self._tree.remove(machine_id)

    def update(self, machine: Machine) -> None:
        """Take over the room of a machine of this group."""
        if self._tree is not None:
            self._put(self._tree, machine)

    def best(self, spec: ContainerSpec) -> Machine | None:
        """Return the machine with room that has most containers of the group; of several, that which had one first."""
        if self._tree is not None:
            return self._tree.least(spec)[1]
        best, most = None, 0
        for machine, members, _ in self._members.values():
            if members > most and machine.has_room(spec):
                best, most = machine, members
        return best

    def _index(self, machine: Machine) -> None:
        if self._tree is not None:
            self._put(self._tree, machine)
        elif len(self._members) > FEW:
            self._tree = RoomTree()
            for each, _, _ in self._members.values():
                self._put(self._tree, each)

    def _put(self, tree: RoomTree, machine: Machine) -> None:
        _, members, number = self._members[machine.id]
        tree.put(machine, number * LATER - members)
