"""The paper's enhanced balancer (section IV): robots of one map share a machine, others go to the least used one.

Containers of one map share its layers in memory and the messages between their robots. Therefore the next container of
a map is placed on a machine that already runs some of them. If none of these has room, the balancer chooses the machine
with the smallest utilization score.
"""

from collections import OrderedDict, defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

import msgspec

from engine.master.balancer import Balancer
from engine.master.balancers.room_tree import RoomTree
from engine.master.machine import Machine
from engine.specs.containers import ContainerSpec

MOST_TIMED = 100_000
"""Largest number of robots whose round trips are stored, whether or not they are connected."""

_NO_TRIPS: Mapping[str, float] = {}

LATE = 0.1
"""Round trip that counts as full use [s]: the time after a scan within which its command is due."""


class Weights(msgspec.Struct, frozen=True):
    """Weights of the terms of the score; only their ratios matter."""

    round_trip: float = 1.0
    network: float = 1.0
    cpu: float = 1.0
    memory: float = 1.0


def utilization(machine: Machine, round_trip: float, weights: Weights) -> float:
    """Return the utilization score of a machine, the paper's weighted mean: 0 if it is idle and near, up to 1.

    The CPU term is the larger of the cores given to containers and the measured load. Containers placed a moment ago do
    not load the CPU yet; by the measured load alone, a machine that looks idle would get every new container until its
    next report.

    Parameters
    ----------
    machine : Machine
    round_trip : float
        Round trip to the robot to be served, or the average round trip [s].
    weights : Weights
    """
    given = machine.given / machine.capacity if machine.capacity else 1.0
    shares = (
        (weights.round_trip, round_trip / LATE),
        (weights.network, machine.network_used / machine.network if machine.network else 0.0),
        (weights.cpu, max(given, machine.cpu / machine.cores if machine.cores else 1.0)),
        (weights.memory, machine.memory_used / machine.memory if machine.memory else 0.0),
    )
    total = sum(weight for weight, _ in shares)
    return sum(weight * min(share, 1.0) for weight, share in shares) / total if total else 0.0


class SameMap(Balancer):
    """Keeps the containers of a group on one machine; by default, a group is a map version.

    Parameters
    ----------
    weights : Weights, optional
        Weights of the utilization score.
    """

    name: ClassVar[str] = "ppaas"
    purpose: ClassVar[str] = "The paper's: robots of one map together, else where least is used."

    def __init__(self, weights: Weights | None = None) -> None:
        super().__init__()
        self._weights = weights or Weights()
        self._tree = RoomTree()
        self._groups: defaultdict[str, ContainerGroup] = defaultdict(ContainerGroup)
        self._groups_on: dict[str, set[str]] = {}
        self._trips: OrderedDict[str, dict[str, float]] = OrderedDict()

    def choose(self, spec: ContainerSpec) -> Machine | None:
        """Return the machine with room that runs most containers of this group, else the least used machine."""
        return self._with_group(spec) or self._least_used(spec)

    def _with_group(self, spec: ContainerSpec) -> Machine | None:
        group = self._groups.get(spec.group)
        return None if group is None else group.best(spec)

    def _least_used(self, spec: ContainerSpec) -> Machine | None:
        trips = self._trips.get(spec.serves, _NO_TRIPS)
        least, found = self._tree.least(spec, trips)
        for machine_id, round_trip in trips.items():  # machines whose round trip to this robot is known
            machine = self.machines.get(machine_id)
            if machine is not None and machine.has_room(spec):
                score = utilization(machine, round_trip, self._weights)
                if score < least:
                    least, found = score, machine
        return found

    def _put(self, machine: Machine) -> None:
        self._tree.put(machine, utilization(machine, machine.round_trip, self._weights))

    def _count(self, machine: Machine, name: str, count: int) -> None:
        group = self._groups[name]
        if group.add(machine, count):
            self._groups_on[machine.id].add(name)
        else:
            self._groups_on[machine.id].discard(name)
            if not group:
                del self._groups[name]

    def _grown(self, machine: Machine) -> None:
        for group in self._groups_on[machine.id]:
            self._groups[group].update(machine)

    # -- what happens --------------------------------------------------------------------------------------------------

    def joined(self, machine: Machine) -> None:
        """Add a machine."""
        super().joined(machine)
        self._groups_on[machine.id] = set()
        self._put(machine)

    def left(self, machine: Machine) -> None:
        """Remove a machine, and its containers from their groups."""
        super().left(machine)
        self._tree.remove(machine.id)
        for group in self._groups_on.pop(machine.id):
            self._groups[group].remove(machine.id)
            if not self._groups[group]:
                del self._groups[group]

    def placed(self, machine: Machine, spec: ContainerSpec) -> None:
        """Count a container in its group, and update the score of its machine."""
        self._count(machine, spec.group, 1)
        self._put(machine)

    def removed(self, machine: Machine, spec: ContainerSpec) -> None:
        """Remove a container from its group, and update the score of its machine."""
        self._count(machine, spec.group, -1)
        self._put(machine)
        self._grown(machine)

    def measured(self, machine: Machine) -> None:
        """Update the score of a machine; its settings may have changed, and its room have grown."""
        self._put(machine)
        self._grown(machine)

    def timed(self, serves: str, machine_id: str, round_trip: float) -> None:
        """Note the round trip between a robot and a machine [s]; over `MOST_TIMED` robots, forget the oldest."""
        self._trips.setdefault(serves, {})[machine_id] = round_trip
        if len(self._trips) > MOST_TIMED:  # the first of a dict would be found behind all that were deleted before it
            self._trips.popitem(last=False)


# -- machines of one map -----------------------------------------------------------------------------------------------

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
