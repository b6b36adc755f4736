"""Plan of the traffic: extends a lifelong plan a few cells ahead of each robot, and keeps the order at each cell."""

from collections import defaultdict, deque
from collections.abc import Mapping, Set

import numpy as np

from ppaas.fleet.cell_rules import CellRules
from ppaas.fleet.lifelong import LifelongPlan
from ppaas.traffic.members import Arrival, Cell, Member

Area = int
"""Number of an area that has room for few robots (`CellRules`)."""

DEPTH = 1
"""Number of cells that are planned for a robot with a goal beyond its grants."""

AT_ONCE = 12
"""Largest number of steps that are planned at once."""

BEHIND = 4
"""Number of planned cells beyond its grants from which on a robot stays in further steps, until it has caught up."""


STEP = 1.0
"""Time of a step, about, by which it is reckoned for how many a goal has been open [s]."""

FARTHEST = 40
"""Number of planned cells beyond its grants up to which a robot is led out of a zone in which robots do not stop."""


class PlanAhead:
    """Plan of all robots that take part, from the ends of their ways.

    Robots drive at different speeds and are late. The plan is only extended while somebody needs cells ahead, and those
    who have enough of them stay where the plan has them. At each cell robots pass in the order of the plan.

    Parameters
    ----------
    rules : CellRules
        Rules of zones; their roadmap is without the cells that nobody may enter.
    heads : mapping of str to int
        Cell of each robot in which the plan begins.
    members : mapping of str to Member
        Robots by name, including all of ``heads``.
    seed : int
        Seed of the random numbers.
    sizes : mapping of str to int
        Size of each robot of ``heads``.
    """

    def __init__(
        self,
        rules: CellRules,
        heads: Mapping[str, Cell],
        members: Mapping[str, Member],
        seed: int,
        sizes: Mapping[str, int],
    ) -> None:
        self._members = [members[name] for name in heads]
        self._index = {name: index for index, name in enumerate(heads)}
        self._rules = rules
        starts = np.fromiter(heads.values(), np.int32, len(heads))
        own = np.fromiter((sizes[name] for name in heads), np.int8, len(heads))
        self._plan = LifelongPlan(rules.roadmap, starts, seed, own)
        self._turns: defaultdict[Cell, deque[str]] = defaultdict(deque)
        self._turns_into: defaultdict[Area, deque[str]] = defaultdict(deque)
        for member in self._members:
            self.rest(member)

    def __contains__(self, name: str) -> bool:
        """Return whether a robot is planned for."""
        return name in self._index

    def enter_first(self, member: Member, cell: Cell) -> None:
        """Plan the first cell of a robot that is on no cell yet."""
        self._append(member, cell)

    def aim(self, member: Member, cell: Cell, now: float) -> bool:
        """Plan a robot to a cell from now on; return whether there is a way."""
        index = self._index[member.name]
        self._plan.set_goal(index, cell, max(int((now - member.goal_since) / STEP), 0))
        if self._plan.can_reach(index):
            self._mark_arrival(member, index)
            return True
        self.rest(member)
        return False

    @property
    def behind(self) -> float:
        """Share of the robots that stay in the plan since they are behind it."""
        return sum(map(self._stays, self._members)) / len(self._members)

    def rest(self, member: Member) -> None:
        """Plan no goal for a robot: it gives way to others, and leaves zones in which robots do not stop."""
        index = self._index[member.name]
        self._plan.set_goal(index, self._near_stop(member))
        member.aim = ""

    def _make_room(self) -> None:
        """Lead robots without a goal out of areas to which others seek to go."""
        sought = self._plan.sought_areas
        for member in self._members if sought else ():
            if not member.aim and self._rules.areas_of(self.end_of(member)) & sought:
                self._plan.set_goal(self._index[member.name], self._near_stop(member, sought))

    def _near_stop(self, member: Member, sought: Set[Area] = frozenset()) -> Cell:
        """Return the cell with the shortest way for a robot in which robots may stop, outside of some areas.

        That in which it is if there is none.
        """
        cell = self.end_of(member)
        roadmap = self._plan.roadmap_of(self._index[member.name])
        known, queue = {cell}, deque([cell])
        while queue and (queue[0] in self._rules.no_stop or self._rules.areas_of(queue[0]) & sought):
            for near in roadmap.neighbours[queue.popleft()].tolist():
                if near >= 0 and near not in known:
                    known.add(near)
                    queue.append(near)
        return queue[0] if queue else cell

    def extend(self) -> bool:
        """Plan steps while robots with goals have few cells ahead and get more; return False if some got none.

        A plan leads robots out of zones in which they do not stop.
        """
        for _ in range(AT_ONCE):
            self._make_room()
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

    def turn_into(self, area: Area) -> str:
        """Return the robot that enters an area next."""
        return self._turns_into[area][0]

    def entered(self, member: Member, cell: Cell) -> None:
        """Remove the next cell of a robot from its queue, and from the orders at the cell and at areas."""
        left, first = member.queue.popleft(), self._turns[cell].popleft()
        assert (left, first) == (cell, member.name)
        if not self._turns[cell]:
            del self._turns[cell]
        for area in self.areas_into(member, member.chain[-1] if member.chain else None, cell):
            self._turns_into[area].popleft()

    def areas_into(self, member: Member, before: Cell | None, cell: Cell) -> set[Area]:
        """Return the areas that a robot enters with a cell: after another one, or from where its way begins."""
        areas = self._rules.areas_of(cell)
        for left in member.base if before is None else {before}:
            areas -= self._rules.areas_of(left)
        return areas

    def _needs_cells(self, member: Member) -> bool:
        if self.end_of(member) in self._rules.no_stop:
            return _cells_ahead(member) < FARTHEST
        return bool(member.aim) and _cells_ahead(member) < DEPTH

    def _stays(self, member: Member) -> bool:
        ahead = _cells_ahead(member)
        return ahead > FARTHEST or (ahead > BEHIND and self.end_of(member) not in self._rules.no_stop)

    def _extend(self) -> None:
        before = self._plan.cells
        waiting = np.fromiter(map(self._stays, self._members), np.bool_, len(before))
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
            return
        for area in self.areas_into(member, _last_cell(member), cell):
            self._turns_into[area].append(member.name)
        member.queue.append(cell)
        self._turns[cell].append(member.name)

    def _comes_back(self, member: Member, cell: Cell) -> bool:
        """Return whether a robot only leaves a cell and comes back, and nobody is in the cell meanwhile.

        It must not leave or enter areas with room for few, which others may use meanwhile.
        """
        tail = [*member.chain[-1:], *list(member.queue)[-2:]]
        if len(tail) < 2 or not member.queue or tail[-2] != cell or isinstance(tail[-1], Arrival):
            return False
        if self._rules.areas_of(cell) != self._rules.areas_of(tail[-1]):
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
            self.rest(member)


def _last_cell(member: Member) -> Cell | None:
    """Return the last cell of a robot's queue, or else of its way."""
    for each in reversed(member.queue):
        if not isinstance(each, Arrival):
            return each
    return member.chain[-1] if member.chain else None


def _cells_ahead(member: Member) -> int:
    return sum(not isinstance(each, Arrival) for each in member.queue)
