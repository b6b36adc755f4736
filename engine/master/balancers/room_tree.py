"""Segment tree that finds a machine with room among thousands without examining each.

A tree node holds the largest room and the smallest score of the machines below it. A search skips every subtree that
cannot contain the result.
"""

import math
from collections.abc import Container

from engine.master.machine import Machine
from engine.specs.containers import ContainerSpec

_NONE = frozenset[str]()
_LEAST_WIDTH = 8


class RoomTree:
    """Machines, in the order in which they were added."""

    def __init__(self) -> None:
        self._allocate(_LEAST_WIDTH)

    def __len__(self) -> int:
        """Return the number of machines."""
        return len(self._slots)

    def put(self, machine: Machine, score: float = 0.0) -> None:
        """Add a machine, or update its room and score."""
        slot = self._slots.get(machine.id)
        if slot is None:
            if self._next == self._width:
                self._rebuild()
            slot = self._slots[machine.id] = self._next
            self._next += 1
        self._machines[slot] = machine
        self._set(slot, machine.room, score)

    def remove(self, machine_id: str) -> None:
        """Remove a machine, if it is in the tree."""
        slot = self._slots.pop(machine_id, None)
        if slot is not None:
            self._machines[slot] = None
            self._set(slot, 0.0, math.inf)

    def first(self, spec: ContainerSpec) -> Machine | None:
        """Return the first added machine that has room for a container; None if no machine has."""
        waiting = [1]
        while waiting:
            node = waiting.pop()
            if self._room[node] < spec.cores:
                continue
            if node < self._width:
                waiting += (2 * node + 1, 2 * node)
                continue
            machine = self._machines[node - self._width]
            if machine is not None and machine.has_room(spec):
                return machine
        return None

    def least(self, spec: ContainerSpec, without: Container[str] = _NONE) -> tuple[float, Machine | None]:
        """Return the smallest score among the machines that have room for a container, and a machine with it.

        The room of a machine may have become less since it was put: the tree then takes over the actual room.

        Parameters
        ----------
        spec : ContainerSpec
        without : container of str
            Ids of machines to skip.

        Returns
        -------
        score : float
            Infinity if no machine has room.
        machine : Machine or None
        """
        best, found = math.inf, None
        room, scores, width = self._room, self._scores, self._width
        waiting = [1]
        while waiting:
            node = waiting.pop()
            if room[node] < spec.cores or scores[node] >= best:
                continue
            if node < width:
                left, right = 2 * node, 2 * node + 1
                waiting += (right, left) if scores[left] <= scores[right] else (left, right)
                continue
            machine = self._machines[node - width]
            if machine is not None and machine.id not in without:
                if machine.has_room(spec):
                    best, found = scores[node], machine
                elif machine.room < room[node]:  # it was not updated since
                    self._set(node - width, machine.room, scores[node])
        return best, found

    def _allocate(self, width: int) -> None:
        self._width = width
        self._next = 0
        self._slots: dict[str, int] = {}
        self._machines: list[Machine | None] = [None] * width
        self._room = [0.0] * (2 * width)
        self._scores = [math.inf] * (2 * width)

    def _rebuild(self) -> None:
        """Rebuild the tree without removed machines, with at least twice the capacity needed."""
        known = [(machine, self._scores[self._width + slot]) for slot, machine in enumerate(self._machines) if machine]
        self._allocate(max(_LEAST_WIDTH, 1 << (2 * len(known)).bit_length()))
        for machine, score in known:
            self.put(machine, score)

    def _set(self, slot: int, room: float, score: float) -> None:
        node = self._width + slot
        self._room[node], self._scores[node] = room, score
        node //= 2
        while node:  # update the ancestors, up to the first that does not change
            left, right = 2 * node, 2 * node + 1
            room, score = max(self._room[left], self._room[right]), min(self._scores[left], self._scores[right])
            if (room, score) == (self._room[node], self._scores[node]):
                return
            self._room[node], self._scores[node] = room, score
            node //= 2
