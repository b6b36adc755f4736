"""The paper's enhanced balancer (section IV): robots of a map go together, and else where least is used.

Containers of one map share its layers in memory and what their robots tell each other, so that a machine which has
some of them is the right one for the next. Where none of these has room, the machine with the smallest utilization
score is taken.
"""

from collections import defaultdict
from collections.abc import Mapping
from typing import ClassVar

from engine.master.balancer import Balancer
from engine.master.balancers.room_tree import RoomTree
from engine.master.balancers.utilization import Weights, utilization
from engine.master.machine import Machine
from engine.specs.containers import ContainerSpec

MOST_TIMED = 100_000
"""Robots whose round trips are known at a time, of those that are connected and those that may come again."""

_NO_TRIPS: Mapping[str, float] = {}


class SameMap(Balancer):
    """Keep the containers of a group together: of a map version, if they name no other.

    Parameters
    ----------
    weights : Weights, optional
        Of what the score is made of.
    """

    name: ClassVar[str] = "ppaas"
    purpose: ClassVar[str] = "The paper's: robots of one map together, else where least is used."

    def __init__(self, weights: Weights | None = None) -> None:
        super().__init__()
        self._weights = weights or Weights()
        self._tree = RoomTree()
        self._groups: defaultdict[str, defaultdict[str, int]] = defaultdict(lambda: defaultdict(int))
        self._trips: defaultdict[str, dict[str, float]] = defaultdict(dict)

    def choose(self, spec: ContainerSpec) -> Machine | None:
        """Return the machine with most of the container's group that has room, else the least used one."""
        return self._with_its_group(spec) or self._least_used(spec)

    def _with_its_group(self, spec: ContainerSpec) -> Machine | None:
        best, most = None, 0
        for machine_id, members in self._groups.get(spec.group, {}).items():
            if members > most and self.machines[machine_id].has_room(spec):
                best, most = self.machines[machine_id], members
        return best

    def _least_used(self, spec: ContainerSpec) -> Machine | None:
        trips = self._trips.get(spec.serves, _NO_TRIPS)
        least, found = self._tree.least(spec, trips)
        for machine_id, round_trip in trips.items():  # for these the robot's own are known
            machine = self.machines.get(machine_id)
            if machine is not None and machine.has_room(spec):
                score = utilization(machine, round_trip, self._weights)
                if score < least:
                    least, found = score, machine
        return found

    def _put(self, machine: Machine) -> None:
        self._tree.put(machine, utilization(machine, machine.round_trip, self._weights))

    # -- what happens --------------------------------------------------------------------------------------------------

    def joined(self, machine: Machine) -> None:
        """Learn of a machine."""
        super().joined(machine)
        self._put(machine)

    def left(self, machine: Machine) -> None:
        """Learn that a machine is gone, and with it what it had of each group."""
        super().left(machine)
        self._tree.remove(machine.id)
        for group in {spec.group for spec in machine.containers.values()}:
            self._groups[group].pop(machine.id, None)
            if not self._groups[group]:
                del self._groups[group]

    def placed(self, machine: Machine, spec: ContainerSpec) -> None:
        """Learn that a machine has one more of a group."""
        self._groups[spec.group][machine.id] += 1
        self._put(machine)

    def removed(self, machine: Machine, spec: ContainerSpec) -> None:
        """Learn that it has one less."""
        members = self._groups[spec.group]
        members[machine.id] -= 1
        if not members[machine.id]:
            del members[machine.id]
        if not members:
            del self._groups[spec.group]
        self._put(machine)

    def measured(self, machine: Machine) -> None:
        """Learn that it is used more or less."""
        self._put(machine)

    def timed(self, serves: str, machine_id: str, round_trip: float) -> None:
        """Learn how far a robot is from a machine; of too many robots those are forgotten that were told of first."""
        self._trips[serves][machine_id] = round_trip
        if len(self._trips) > MOST_TIMED:
            del self._trips[next(iter(self._trips))]
