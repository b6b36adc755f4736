"""Coordinator of the traffic of a map: reports of robots in, grants out. It has no clock and does no I/O."""

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import replace

from ppaas.errors import PPaaSError
from ppaas.fleet.problem import is_connected
from ppaas.messages.fleet.traffic import NO_WAY, MapPoint, TrafficGrants, TrafficReport
from ppaas.traffic.grants import GrantWriter, cells_together, window_of
from ppaas.traffic.members import Arrival, Cell, Member
from ppaas.traffic.occupancy import Occupancy
from ppaas.traffic.plan_ahead import PlanAhead
from ppaas.traffic.plan_starts import cells_near, heads_of, obstacles_in
from ppaas.traffic.settings import TrafficParameters
from ppaas.traffic.sizes import REACH, MakeRoadmap
from ppaas.traffic.spurs import Spurs

GATHER = 1.0
"""Time in which a new coordinator listens to reports, before it chooses its epoch [s]."""

STALE, FOLLOWED = 0.2, 40.0
"""Share of robots behind the plan from which on all are replanned, and the time for which a plan is followed first
[s]."""

LOOK = 2.0
"""Time between two looks for a free cell for robots that had none in reach [s]."""

RETRY = 0.5
"""Time after which the plan is tried to be extended again, if nobody got on by it [s]."""

NEAR = 0.75
"""Largest distance of a goal from the cell that is taken for it, as a part of the distance between two cells."""


class Coordinator:
    """Grants robots cells in the order of one plan, so that no two are in one cell, and none waits for ever.

    A robot that is granted a cell keeps it until it has left it or gives it back. Cells are granted in the order of a
    plan that is extended while robots drive (`PlanAhead`), and remade where many robots are behind it: a robot is
    granted the next cell once all who enter it earlier in the plan have left it. Late robots so delay others, and never
    meet them (an action dependency graph: Hönig et al., "Persistent and Robust Execution of MAPF Schedules in
    Warehouses", 2019).

    Parameters
    ----------
    make_roadmap : callable
        Returns the roadmap for robots of some radii.
    parameters : TrafficParameters
    epoch : int
        Epoch that the coordinator before this one had; 0 for none.
    now : float
        Time at which it begins [s]; all other times are by the same clock.

    Attributes
    ----------
    occupancy : Occupancy
        The robots, and what they hold.
    epoch : int
    """

    def __init__(
        self, make_roadmap: MakeRoadmap, parameters: TrafficParameters, epoch: int = 0, now: float = 0.0
    ) -> None:
        self.occupancy = Occupancy(make_roadmap, parameters)
        self.epoch = epoch
        self._plan: PlanAhead | None = None
        self._seeds = itertools.count()
        self._writer = GrantWriter()
        self._spurs = Spurs(self.occupancy)
        self._granting = False
        self._begin = now + GATHER
        self._plan_at = self._look_at = self._planned_at = now

    @property
    def members(self) -> dict[str, Member]:
        """Robots by name."""
        return self.occupancy.members

    @property
    def spacing(self) -> float:
        """Distance of neighbouring cells [m]; 0 before there is a robot."""
        return 0.0 if self.occupancy.map is None else self.occupancy.map.spacing

    def report(self, report: TrafficReport, now: float) -> None:
        """Take a report of a robot; one that is older than another is ignored.

        Raises
        ------
        InvalidInput
            A number is not finite, or the counts do not fit each other; nothing is changed.
        """
        if self.occupancy.report(report, now, self.epoch) and report.epoch > self.epoch:
            self._outrank(report.epoch, now)

    def _is_ours(self, member: Member) -> bool:
        return member.report.epoch == self.epoch

    def _outrank(self, epoch: int, now: float) -> None:
        """Begin another epoch, after another coordinator's; nothing is granted until all robots know of it."""
        self.epoch = epoch
        self._granting, self._begin = False, now + GATHER

    # -- steps ---------------------------------------------------------------------------------------------------------

    def step(self, now: float) -> list[TrafficGrants]:
        """Watch robots, plan, and grant; return what is to be sent."""
        self.occupancy.watch(now)
        if not self._granting:
            return self._gather(now)
        if self.occupancy.map is not None and not self._let_alone():
            self._plan_ways(now)
            self._grant(now)
        return self._writer.due(self._messages(now), now)

    def _gather(self, now: float) -> list[TrafficGrants]:
        """Listen to the robots; then choose an epoch, and begin once each of them knows of it or says nothing."""
        if now < self._begin:
            return []
        if self._begin != float("-inf"):
            self.epoch, self._begin = self.epoch + 1, float("-inf")
        self._granting = all(self._is_ours(each) or self._is_silent(each, now) for each in self.members.values())
        return self._writer.due(self._messages(now), now)

    def _let_alone(self) -> bool:
        """Return whether no robot may be granted cells, since one drives freely."""
        return self._drives_alone() or any(member.report.free for member in self.occupancy.present)

    def _drives_alone(self) -> bool:
        """Return whether a robot is alone and may drive freely: there are no lanes, which it would not know."""
        return len(self.occupancy.present) == 1 and not self.occupancy.has_lanes

    # -- the plan ------------------------------------------------------------------------------------------------------

    def _plan_ways(self, now: float) -> None:
        if self.occupancy.outdated or self._has_room_for_more(now) or self._is_stale(now):
            self._plan_anew(now)
        plan = self._plan
        if plan is None:
            return
        for member in self._planned(plan):
            self._head_for_goal(plan, member, now)
        if now >= self._plan_at and not plan.extend():
            self._plan_at = now + RETRY

    def _is_stale(self, now: float) -> bool:
        """Return whether many robots are behind the plan, and it has been followed for a while.

        Robots that are behind it stand in it, and others are led around them or wait there.
        """
        plan = self._plan
        return plan is not None and now - self._planned_at >= FOLLOWED and plan.behind >= STALE

    def _has_room_for_more(self, now: float) -> bool:
        """Return whether there is a free cell now for a robot that had none in reach, looked at every few seconds."""
        if now < self._look_at or self._plan is None or not any(map(self._is_left_out, self.members.values())):
            return False
        self._look_at = now + LOOK
        return any(name not in self._plan for name in heads_of(self.occupancy))

    def _is_left_out(self, member: Member) -> bool:
        left_out = self._plan is None or member.name not in self._plan
        return left_out and member.standing == "joined" and not member.misfit

    def _planned(self, plan: PlanAhead) -> Iterable[Member]:
        return [member for member in self.members.values() if member.name in plan]

    def _plan_anew(self, now: float) -> None:
        """Plan from the ends of all ways; those who do not take part are obstacles."""
        self.occupancy.outdated, self._planned_at = False, now
        heads = heads_of(self.occupancy)
        for member in self.members.values():
            member.queue.clear()
            member.aim = member.no_way = ""
        rules = self.occupancy.rules
        left_out = obstacles_in(self.occupancy, heads) - set(heads.values())
        rules = replace(rules, roadmap=rules.roadmap.without(left_out))
        sizes = {name: self.occupancy.size_of(self.members[name]) for name in heads}
        self._plan = plan = PlanAhead(rules, heads, self.members, next(self._seeds), sizes) if heads else None
        for name, cell in heads.items():
            if plan is not None and not self.members[name].chain:
                plan.enter_first(self.members[name], cell)

    def _head_for_goal(self, plan: PlanAhead, member: Member, now: float) -> None:
        goal_id = member.report.goal_id
        while member.at_goal and member.queue[0] != Arrival(goal_id):
            member.queue.popleft()
        if not goal_id:
            if member.aim:
                plan.rest(member)
            return
        given_up = goal_id in {member.refused[0], member.no_way}
        if member.aim == goal_id or Arrival(goal_id) in member.queue or given_up:
            return
        self._aim(plan, member, now)

    def _aim(self, plan: PlanAhead, member: Member, now: float) -> None:
        goal_id, goal = member.report.goal_id, member.report.goal
        cells, size = self.occupancy.cells, self.occupancy.size_of(member)
        try:
            cell = cells.nearest(goal.x, goal.y, NEAR * cells.spacing, size)
        except PPaaSError as error:
            member.refused = goal_id, f"robots of the traffic cannot stand there: {error}"
            return
        if cell in self.occupancy.rules.no_stop:
            member.refused = goal_id, "it is in a zone of the map in which robots do not stop"
            return
        member.aim = goal_id
        if plan.aim(member, cell, now):
            return
        member.no_way = goal_id
        if not is_connected(self.occupancy.rules.roadmap.for_size(size), plan.end_of(member), cell):
            closed = is_connected(cells.roadmap.for_size(size), plan.end_of(member), cell)
            why = ": zones of the map close it" if closed else ""
            member.refused = goal_id, f"there is no way to it for the robots of the traffic{why}"
            return
        holders = [name for name in self.occupancy.holders[cell] if self.occupancy.is_given_up(name)]
        if holders:
            member.refused = goal_id, f"robot {holders[0]} stands on it and does not move"

    # -- grants --------------------------------------------------------------------------------------------------------

    def _grant(self, now: float) -> None:
        plan = self._plan
        if plan is None:
            return
        self._end_spurs()
        for member in sorted(self._planned(plan), key=lambda each: each.goal_since):
            if not self._may_be_granted(member, now):
                continue
            why: str | None = None
            while why is None and member.ahead < window_of(member.report, self.spacing):
                why = self._grant_next(plan, member, now)
            if member.at_goal:
                why = self._spurs.decide(member, now)
            self._wait(member, why or "" if member.ahead == 0 else "", now)

    def _end_spurs(self) -> None:
        waited_for = {member.waits_for for member in self.members.values()}
        for member in filter(self._is_ours, self.members.values()):
            number = self._writer.next_number(member.name)
            self._spurs.end(member, number, waited_for=member.name in waited_for)

    def _may_be_granted(self, member: Member, now: float) -> bool:
        gives_back = member.name in self.occupancy.gives_back
        return self._is_ours(member) and not gives_back and not self._is_silent(member, now)

    def _is_silent(self, member: Member, now: float) -> bool:
        return now - member.heard_at > self.occupancy.parameters.silence

    def _grant_next(self, plan: PlanAhead, member: Member, now: float) -> str | None:
        """Grant a robot the next cell of its plan, or return what it waits for; empty if it needs no more cells now.

        Cells in which it does not stop are granted together with the one behind them.
        """
        if not member.queue:
            return NO_WAY if member.report.goal_id else ""
        if member.at_goal:
            return ""
        cells = cells_together(member, self.occupancy.rules.no_stop)
        if not cells:
            return NO_WAY
        why = self._hindrance(plan, member, cells, now)
        if why and len(cells) > 1 and self._waits_for(why, member.name):
            cells = cells[:1]  # both would wait for ever: it stops where it should not
            why = self._hindrance(plan, member, cells, now)
        if why:
            return why
        for cell in cells:
            plan.entered(member, cell)
            member.chain.append(cell)
            self.occupancy.holders.hold(member.name, cell)
        return None

    def _hindrance(self, plan: PlanAhead, member: Member, cells: Sequence[Cell], now: float) -> str:
        """Return because of whom a robot may not be granted its next cells; empty if it may."""
        last = member.chain[-1] if member.chain else None
        gap = 2.0 * self.occupancy.parameters.margin  # poses of both are only right to the margin
        for cell in cells:
            first = plan.turn_of(cell)
            if first != member.name:
                return first
            other = self.occupancy.holders.in_the_way(member, cell, self.occupancy.cells, gap)
            other = other or self._has_no_room(plan, member, plan.areas_into(member, last, cell))
            if other:
                return other
            outsider = self.occupancy.outsiders.in_cell(cell, now)
            if outsider:
                return outsider
            last = cell
        return ""

    def _has_no_room(self, plan: PlanAhead, member: Member, areas: Iterable[int]) -> str:
        """Return a robot because of which there is no room for another in areas; empty if there is."""
        for area in areas:
            first = plan.turn_into(area)
            if first != member.name:
                return first
            others = self.occupancy.inside(area) - {member.name}
            if len(others) >= self.occupancy.rules.roadmap.room[area]:
                return min(others)
        return ""

    def _waits_for(self, name: str, other: str) -> bool:
        """Return whether a robot waits for another, or for one that waits for it."""
        known: set[str] = set()
        while name in self.members and name not in known:
            known.add(name)
            name = self.members[name].waits_for
            if name == other:
                return True
        return False

    @staticmethod
    def _wait(member: Member, why: str, now: float) -> None:
        if bool(why) != bool(member.waits_for):
            member.waits_since = now if why else float("inf")
        member.waits_for = why

    def _messages(self, now: float) -> Iterable[TrafficGrants]:
        alone = self._granting and self._drives_alone()
        for member in self.members.values():
            refused = self._refusal(member)
            report = member.report
            held = () if member.restored else member.chain
            way = [MapPoint(*self.occupancy.cells.centre(cell)) for cell in held]
            yield TrafficGrants(
                report.header, member.name, self.epoch, 0, report.revision, self.spacing,
                first=member.first, way=way, at_goal=self._ends_at_goal(member),
                goal_id=report.goal_id if refused or self._leads_to_goal(member) else "",
                free=alone or member.standing == "out",
                give_back=self._gives_back_now(member, alone=alone),
                waits_for=member.waits_for,
                refused=refused,
                spur=[] if member.spur is None or member.spur.ended_by else [member.spur.place],
            )  # fmt: skip

    def _ends_at_goal(self, member: Member) -> bool:
        return member.at_goal and self._granting and member.decided == member.report.goal_id

    @staticmethod
    def _leads_to_goal(member: Member) -> bool:
        return bool(member.aim) or Arrival(member.report.goal_id) in member.queue

    def _is_far(self, member: Member) -> bool:
        return self._is_left_out(member) and not member.report.free and not cells_near(self.occupancy, member)

    def without_cells(self, member: Member) -> str:
        """Return why there are no cells for a robot; empty if there are, or if it drives without."""
        if not (member.misfit or self._is_left_out(member)) or member.standing == "out" or self._drives_alone():
            return ""
        if self._granting and self.occupancy.map is not None and self._is_far(member):
            return f"the robot is farther than {REACH * self.spacing:.2g} m from where robots of the traffic drive"
        return member.misfit

    def _refusal(self, member: Member) -> str:
        """Return why the goal of a robot cannot be reached; empty if it can."""
        if why := self.without_cells(member):
            return why
        return member.refused[1] if member.refused[0] == member.report.goal_id else ""

    def _gives_back_now(self, member: Member, *, alone: bool) -> bool:
        if member.report.free:
            return not alone and member.standing != "out"
        return member.name in self.occupancy.gives_back
