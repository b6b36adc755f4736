"""Spurs: ways of robots to goals beside the centres of their cells, where they hold all cells that they touch."""

import math
from dataclasses import replace

from ppaas.traffic.holders import spur_to
from ppaas.traffic.lines import OtherLines
from ppaas.traffic.members import Member, Spur
from ppaas.traffic.occupancy import Occupancy
from ppaas.traffic.room_in_cells import beside, nearest_in_cell

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
