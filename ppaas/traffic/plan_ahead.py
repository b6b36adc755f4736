"""Ways of the traffic: a lifelong plan a few cells ahead of each robot, and spurs to goals beside centres."""

import math
from collections import defaultdict, deque
from collections.abc import Mapping, Set
from dataclasses import replace

import numpy as np

from ppaas.fleet.cell_rules import CellRules
from ppaas.fleet.lifelong import LifelongPlan
from ppaas.traffic.holders import OtherLines, spur_to
from ppaas.traffic.members import Arrival, Cell, Member, Spur
from ppaas.traffic.occupancy import Occupancy
from ppaas.traffic.room_in_cells import beside, nearest_in_cell

# -- plan of the traffic -----------------------------------------------------------------------------------------------

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
        self._sizes = sizes
        own = np.fromiter((rules.kind(sizes[name], cell, None) for name, cell in heads.items()), np.int8, len(heads))
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
        kind = self._rules.kind(self._sizes[member.name], self.end_of(member), cell)
        self._plan.set_goal(index, cell, max(int((now - member.goal_since) / STEP), 0), kind)
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
        kind = self._rules.kind(self._sizes[member.name], self.end_of(member), None)
        self._plan.set_goal(self._index[member.name], self._near_stop(member), size=kind)
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
            self._shut_behind(member, int(before[index]), int(after[index]))
            self._append(member, int(after[index]))
            self._mark_arrival(member, index)

    def _shut_behind(self, member: Member, left: Cell, cell: Cell) -> None:
        """Let nobody who has left a car give way back into it: its doors may shut."""
        goal = int(self._plan.goals[self._index[member.name]])
        if self._rules.car_of(left) is not None and self._rules.car_of(cell) is None:
            self._plan.set_size(self._index[member.name], self._rules.kind(self._sizes[member.name], cell, goal))

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


# -- spurs -------------------------------------------------------------------------------------------------------------

SETTLES = 5.0
"""Time for which a robot waits in the cell of its goal until the cells around are free [s]; then it stops in it."""


class Spurs:
    """Decides where robots stop that have been granted the cells of their goals.

    A goal may be up to half a cell off the centre. If the robot stays farther from it than its tolerance where it is
    wholly in the cell, it is granted a spur: all cells that it touches on the straight way from the centre to the goal,
    at once, and only while they are free. Cells of a spur have no turns in the plan. So none waits for ever because of
    it: the robot drives back to the centre on its own as soon as it goes on or somebody waits for it.

    Parameters
    ----------
    occupancy : Occupancy
        Robots, and the cells that they hold.
    """

    def __init__(self, occupancy: Occupancy) -> None:
        self._occupancy = occupancy

    def decide(self, member: Member, now: float) -> str:
        """Decide where a robot stops in or beside the last cell of its way; return whom it waits for, if any."""
        goal_id = member.report.goal_id
        if member.decided == goal_id or member.spur is not None:  # it drives back from the goal before first
            return ""
        spur = self._spur_to_goal(member)
        other = "" if spur is None else self._hindrance(member, spur, now)
        if member.ahead or member.settles[0] != goal_id:
            member.settles = goal_id, now + SETTLES
        if other and now < member.settles[1]:
            return other
        if spur is not None and not other:
            self._occupancy.holders.hold_spur(member, spur)
        member.decided = goal_id
        return ""

    def _hindrance(self, member: Member, spur: Spur, now: float) -> str:
        """Return who is in the way of a robot on a spur; empty if nobody is."""
        occupancy = self._occupancy
        lines = OtherLines(member, occupancy.members.values(), occupancy.cells)
        others = lines.near(spur.line, 2.0 * beside(occupancy.cells.spacing, member.report.radius))
        others = others.union(*(occupancy.holders[cell] for cell in spur.cells)) - {member.name}
        if others:
            return min(others)
        return next(filter(None, (occupancy.outsiders.in_cell(cell, now) for cell in sorted(spur.cells))), "")

    def _spur_to_goal(self, member: Member) -> Spur | None:
        """Return the spur to a goal; None if it is not needed, or leads where rules of zones begin."""
        occupancy, report, last = self._occupancy, member.report, member.chain[-1]
        centre, spacing = occupancy.cells.centre(last), occupancy.cells.spacing
        goal = report.goal.x, report.goal.y
        near = nearest_in_cell(goal, centre, beside(spacing, report.radius))
        if math.dist(near, goal) <= report.tolerance:
            return None
        spur = spur_to(occupancy.cells, member, report.goal, report.goal_id)
        areas = occupancy.rules.areas_of(last)
        if any(cell in occupancy.rules.no_stop or occupancy.rules.areas_of(cell) - areas for cell in spur.cells):
            return None
        return spur

    @staticmethod
    def _is_over(member: Member, spur: Spur, *, waited_for: bool) -> bool:
        """Return whether a robot has to drive back: it does not stop in its cell by the plan, or is in others' way."""
        report = member.report
        if report.goal_id == spur.goal_id != "":
            return not member.at_goal
        return bool(member.ahead or report.goal_id or not report.spur or waited_for)

    def end(self, member: Member, number: int, *, waited_for: bool) -> None:
        """Ask a robot to drive back that goes on or is waited for; free its spur once it has.

        Parameters
        ----------
        member : Member
        number : int
            Number that the next grants will have which say something new.
        waited_for : bool
            Whether others wait for this robot.
        """
        spur, report = member.spur, member.report
        if spur is None:
            return
        if not spur.ended_by:
            if self._is_over(member, spur, waited_for=waited_for):
                member.spur, member.decided = replace(spur, ended_by=number), ""
        elif report.grants >= spur.ended_by and not report.spur:
            self._occupancy.holders.let_spur_go(member)
