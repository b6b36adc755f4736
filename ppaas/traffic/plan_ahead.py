"""Plan of the traffic: extends a lifelong plan a few cells ahead of each robot, and keeps the order at each cell."""

from collections import defaultdict, deque
from collections.abc import Mapping

import numpy as np

from ppaas.fleet.lifelong import LifelongPlan
from ppaas.fleet.roadmap import Roadmap
from ppaas.traffic.members import Arrival, Cell, Member

DEPTH = 1
"""Number of cells that are planned for a robot with a goal beyond its grants."""

AT_ONCE = 12
"""Largest number of steps that are planned at once."""

BEHIND = 4
"""Number of planned cells beyond its grants from which on a robot stays in further steps, until it has caught up."""


class PlanAhead:
    """Plan of all robots that take part, from the ends of their ways.

    Robots drive at different speeds and are late. The plan is only extended while somebody needs cells ahead, and those
    who have enough of them stay where the plan has them. At each cell robots pass in the order of the plan.

    Parameters
    ----------
    roadmap : Roadmap
        Without the cells that nobody may enter.
    heads : mapping of str to int
        Cell of each robot in which the plan begins.
    members : mapping of str to Member
        Robots by name, those of ``heads`` among them.
    seed : int
        Seed of the random numbers.
    """

    def __init__(self, roadmap: Roadmap, heads: Mapping[str, Cell], members: Mapping[str, Member], seed: int) -> None:
        self._members = [members[name] for name in heads]
        self._index = {name: index for index, name in enumerate(heads)}
        self._plan = LifelongPlan(roadmap, np.fromiter(heads.values(), np.int32, len(heads)), seed)
        self._turns: defaultdict[Cell, deque[str]] = defaultdict(deque)

    def __contains__(self, name: str) -> bool:
        """Return whether a robot is planned for."""
        return name in self._index

    def enter_first(self, member: Member, cell: Cell) -> None:
        """Let a robot that is on no cell yet enter the one in which its plan begins."""
        self._append(member, cell)

    def aim(self, member: Member, cell: Cell) -> bool:
        """Plan a robot to a cell from now on; return whether there is a way."""
        index = self._index[member.name]
        self._plan.set_goal(index, cell)
        if self._plan.can_reach(index):
            self._mark_arrival(member, index)
            return True
        self.rest(member)
        return False

    def rest(self, member: Member) -> None:
        """Plan no goal for a robot: it gives way to others."""
        index = self._index[member.name]
        self._plan.set_goal(index, int(self._plan.cells[index]))
        member.aim = ""

    def extend(self) -> bool:
        """Plan steps while robots with goals have few cells ahead and get more; return False if some got none."""
        for _ in range(AT_ONCE):
            needy = [member for member in self._members if self._needs_cells(member)]
            if not needy:
                return True
            before = sum(len(member.queue) for member in needy)
            self._extend()
            if sum(len(member.queue) for member in needy) <= before:
                return False
        return True

    def end_of(self, member: Member) -> Cell:
        """Return the cell in which a robot is at the end of the plan."""
        return int(self._plan.cells[self._index[member.name]])

    def turn_of(self, cell: Cell) -> str:
        """Return the robot that enters a cell next."""
        return self._turns[cell][0]

    def entered(self, member: Member, cell: Cell) -> None:
        """Remove the next cell of a robot from its queue, and from the order at the cell."""
        left, first = member.queue.popleft(), self._turns[cell].popleft()
        assert (left, first) == (cell, member.name)
        if not self._turns[cell]:
            del self._turns[cell]

    def _needs_cells(self, member: Member) -> bool:
        return bool(member.aim) and _cells_ahead(member) < DEPTH

    def _extend(self) -> None:
        before = self._plan.cells
        waiting = np.fromiter((_cells_ahead(member) > BEHIND for member in self._members), np.bool_, len(before))
        after = self._plan.extend(waiting)
        for index in np.nonzero(after != before)[0].tolist():
            member = self._members[index]
            self._append(member, int(after[index]))
            self._mark_arrival(member, index)

    def _append(self, member: Member, cell: Cell) -> None:
        """Append a cell to the queue of a robot, unless it only comes back to the one before."""
        if self._comes_back(member, cell):
            left = member.queue.pop()
            assert not isinstance(left, Arrival)
            self._leave_out(member.name, left)
        else:
            member.queue.append(cell)
            self._turns[cell].append(member.name)

    def _comes_back(self, member: Member, cell: Cell) -> bool:
        """Return whether a robot only leaves a cell and comes back, and nobody is in the cell meanwhile."""
        tail = [*member.chain[-1:], *list(member.queue)[-2:]]
        if len(tail) < 2 or not member.queue or tail[-2] != cell or isinstance(tail[-1], Arrival):
            return False
        turns = self._turns.get(cell)
        return (turns[-1] if turns else "") == (member.name if len(member.queue) > 1 else "")

    def _leave_out(self, name: str, cell: Cell) -> None:
        """Remove the last entry of a robot into a cell from the order there."""
        turns = self._turns[cell]
        turns.reverse()
        turns.remove(name)
        turns.reverse()
        if not turns:
            del self._turns[cell]

    def _mark_arrival(self, member: Member, index: int) -> None:
        """Mark that a robot reaches its goal in the plan; afterwards it gives way. One without a goal stays here."""
        cells = self._plan.cells
        if member.aim and cells[index] == self._plan.goals[index]:
            member.queue.append(Arrival(member.aim))
            self.rest(member)
        elif not member.aim:
            self._plan.set_goal(index, int(cells[index]))


def _cells_ahead(member: Member) -> int:
    return sum(not isinstance(each, Arrival) for each in member.queue)
