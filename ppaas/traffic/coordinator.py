"""Coordinator of the traffic of a map: reports of robots in, grants, states and checkpoints out. It does no I/O."""

import itertools
import math
from collections import Counter
from collections.abc import Collection, Container, Iterable, Sequence
from dataclasses import replace

import msgspec

from ppaas.decoding import from_msgpack
from ppaas.errors import InvalidInput, PPaaSError
from ppaas.fleet.problem import is_connected
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.fleet.traffic import NO_WAY, MapPoint, TrafficGrants, TrafficReport, TrafficRobot, TrafficState
from ppaas.traffic.approaches import approach_of
from ppaas.traffic.members import Arrival, Cell, Member
from ppaas.traffic.occupancy import Occupancy
from ppaas.traffic.plan_ahead import PlanAhead, Spurs
from ppaas.traffic.settings import TrafficParameters
from ppaas.traffic.sizes import REACH, MakeRoadmap

# -- grants as messages ------------------------------------------------------------------------------------------------

ROUND_TRIP = 0.5
"""Time from a report to the grants that answer it [s], over a slow network."""

REPEAT = 0.5
"""Time after which grants that have not changed are sent again, since messages may be lost [s]."""

MOST_AHEAD = 8
"""Largest number of cells that a robot is granted ahead."""


def window_of(report: TrafficReport, spacing: float) -> int:
    """Return how many cells to grant ahead, so that the robot never brakes while it waits for the next grant."""
    needed = report.braking + ROUND_TRIP * report.speed
    return min(1 + math.ceil(needed / spacing), MOST_AHEAD)


def cells_together(member: Member, no_stop: Container[Cell]) -> list[Cell]:
    """Return the next cells of a robot that are granted together: up to the first one in which it may stop.

    One cell, if it is in a zone already in which it does not stop. No cells if the plan does not lead out of one yet.
    """
    is_inside = bool(member.chain) and member.chain[-1] in no_stop
    cells: list[Cell] = []
    for cell in member.queue:
        if isinstance(cell, Arrival):
            return []
        if cell in cells:  # it goes round in the zone, and others pass meanwhile
            return cells
        cells.append(cell)
        if is_inside or cell not in no_stop:
            return cells
    return []


class GrantWriter:
    """Sends grants when they change, and again now and then."""

    def __init__(self) -> None:
        self._sent: dict[str, tuple[float, TrafficGrants]] = {}
        # Numbers of robots that were forgotten stay: a robot that comes back ignores numbers that it knows.
        self._numbers: Counter[str] = Counter()

    def next_number(self, robot: str) -> int:
        """Return the number that the next grants of a robot will have."""
        return self._numbers[robot] + 1

    def due(self, messages: Iterable[TrafficGrants], now: float) -> list[TrafficGrants]:
        """Return the messages that are to be sent now, with their numbers and times.

        Parameters
        ----------
        messages : iterable of TrafficGrants
            The grants of all robots, without numbers.
        now : float
            Time [s].
        """
        due, sent = [], {}
        for grants in messages:
            last = self._sent.get(grants.robot)
            if last is None or now - last[0] >= REPEAT or not _equal(last[1], grants):
                self._numbers[grants.robot] += 1
                header = msgspec.structs.replace(grants.header, stamp=Time.of(now))
                due.append(msgspec.structs.replace(grants, number=self._numbers[grants.robot], header=header))
                last = now, grants
            sent[grants.robot] = last
        self._sent = sent
        return due


def _equal(one: TrafficGrants, other: TrafficGrants) -> bool:
    """Return whether grants without numbers say the same, whatever their times."""
    return msgspec.structs.replace(one, header=other.header) == other


# -- starts of a plan --------------------------------------------------------------------------------------------------


def heads_of(occupancy: Occupancy) -> dict[str, Cell]:
    """Return the cells at the ends of ways; robots without a way get the nearest cell that nobody else has.

    Of robots that report ways to one cell, one is wrong: all of them are asked to give back the rest of their ways.
    """
    joined = [member for member in occupancy.members.values() if member.standing == "joined" and not member.misfit]
    ends = Counter(member.chain[-1] for member in joined if member.chain)
    occupancy.gives_back |= {member.name for member in joined if member.chain and ends[member.chain[-1]] > 1}
    heads = {member.name: member.chain[-1] for member in joined if member.chain and ends[member.chain[-1]] == 1}
    taken = set(ends)
    for member in joined:
        if not member.chain:
            near = cells_to_begin(occupancy, member)
            free = [cell for cell in near if cell not in taken and not _is_granted(occupancy, cell, member.name)]
            if free:
                heads[member.name] = free[0]
                taken.add(free[0])
    return heads


def cells_near(occupancy: Occupancy, member: Member) -> list[Cell]:
    """Return the cells to which a robot without a way may be led, the nearest one first."""
    report, cells = member.report, occupancy.cells
    return cells.nearby(report.x, report.y, REACH * cells.spacing, occupancy.size_of(member))


def cells_to_begin(occupancy: Occupancy, member: Member) -> list[Cell]:
    """Return the cells to which a robot without a way is led, nearest first: none in or out of a car of a lift.

    With a goal on the other side of the door, it may be led there too.
    """
    rules, near = occupancy.rules, cells_near(occupancy, member)
    cars = {rules.car_of(cell) for cell in member.base} - {None}
    if member.report.goal_id:
        goal = member.report.goal
        cars |= {rules.car_of(occupancy.cells.closest(goal.x, goal.y))}
        return [cell for cell in near if rules.car_of(cell) in cars | {None}]
    return [cell for cell in near if rules.car_of(cell) in (cars or {None})]


def _is_granted(occupancy: Occupancy, cell: Cell, but: str) -> bool:
    return any(cell in occupancy.members[name].chain for name in occupancy.holders[cell] - {but})


def obstacles_in(occupancy: Occupancy, heads: Collection[str]) -> set[Cell]:
    """Return the cells that are not planned: where something was found, and cells of robots without a head."""
    aside = (member.held for name, member in occupancy.members.items() if name not in heads)
    return set(occupancy.blocked).union(*aside)


# -- the coordinator: reports of robots in, grants out -----------------------------------------------------------------

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


class TrafficCoordinator:
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
        kind = self.occupancy.rules.kind(size, plan.end_of(member), cell)
        if not is_connected(self.occupancy.rules.roadmap.for_size(kind), plan.end_of(member), cell):
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
            # The head of the queue may be the end of a goal that was called off: the next step removes that.
            if member.at_goal and member.queue[0] == Arrival(member.report.goal_id):
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
            approach = self._approach(member, now)
            yield TrafficGrants(
                report.header, member.name, self.epoch, 0, report.revision, self.spacing,
                first=member.first, way=way, at_goal=self._ends_at_goal(member),
                goal_id=report.goal_id if refused or self._leads_to_goal(member) else "",
                free=(alone and not report.aside) or member.standing == "out",
                give_back=self._gives_back_now(member, alone=alone),
                waits_for=member.waits_for,
                refused=refused,
                spur=[] if member.spur is None or member.spur.ended_by else [member.spur.place],
                approach=approach,
            )  # fmt: skip

    def _approach(self, member: Member, now: float) -> list[MapPoint]:
        """Return the approach that a robot is granted; note whom it waits for."""
        occupancy, asks = self.occupancy, len(member.report.approach) > 1
        if not (asks and self._granting and self._is_ours(member) and occupancy.map is not None):
            return []
        granted, why = approach_of(member, self.members.values(), occupancy.cells, occupancy.outsiders, now)
        self._wait(member, why, now)
        return granted

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


# -- checkpoint of the traffic -----------------------------------------------------------------------------------------


class TrafficCheckpoint(msgspec.Struct):
    """State of a coordinator from which the next one begins.

    Parameters
    ----------
    epoch : int
    reports : list of TrafficReport
        The newest of each robot, with all cells that it may hold or be granted soon as its way.
    goals : int
        Number of goals reached.
    out : list of str
        Robots that an operator has taken out.
    """

    epoch: int
    reports: list[TrafficReport] = []
    goals: int = 0
    out: list[str] = []


def checkpoint_of(coordinator: TrafficCoordinator) -> bytes:
    """Return the checkpoint of a coordinator."""
    occupancy = coordinator.occupancy
    out = [name for name, member in occupancy.members.items() if member.standing == "out"]
    return msgspec.msgpack.encode(TrafficCheckpoint(coordinator.epoch, occupancy.known(), occupancy.goals, out))


def restore(coordinator: TrafficCoordinator, state: bytes, now: float) -> None:
    """Start a coordinator from a checkpoint: it waits for the robots in it, and treats what they held as held.

    Those that were taken out stay out.

    Raises
    ------
    InvalidInput
        The checkpoint is not valid.
    """
    try:
        read = from_msgpack(state, TrafficCheckpoint)
    except msgspec.DecodeError as error:
        raise InvalidInput(f"the checkpoint of the traffic is not valid: {error}") from error
    coordinator.epoch, coordinator.occupancy.goals = read.epoch, read.goals
    for report in read.reports:
        coordinator.report(report, now)
    for member in coordinator.members.values():
        member.restored = True
    for name in set(read.out) & coordinator.members.keys():
        coordinator.occupancy.take_out(name)


# -- state of the traffic, for those who look at it --------------------------------------------------------------------


def state_of(coordinator: TrafficCoordinator, stamp: float, now: float, seconds: float) -> TrafficState:
    """Return the traffic as it is.

    Parameters
    ----------
    coordinator : TrafficCoordinator
    stamp : float
        Time since 1970, for the header [s].
    now : float
        Time by the clock of the coordinator [s].
    seconds : float
        Time that it has planned and granted for so far [s].
    """
    robots = [_robot(coordinator, member, now) for _, member in sorted(coordinator.members.items())]
    header = Header(stamp=Time.of(stamp), frame_id="map")
    return TrafficState(header, coordinator.epoch, coordinator.spacing, robots, coordinator.occupancy.goals, seconds)


def _robot(coordinator: TrafficCoordinator, member: Member, now: float) -> TrafficRobot:
    report = member.report
    way = [MapPoint(*coordinator.occupancy.cells.centre(cell)) for cell in [*sorted(member.base), *member.chain]]
    waited = now - member.waits_since if member.waits_for else 0.0
    state, why = _state(member), member.waits_for
    if none := coordinator.without_cells(member):
        state, why, waited = "no_cells", none, 0.0
    return TrafficRobot(
        member.name, state, report.x, report.y, report.theta, way, why, report.goal_id, report.goal, waited
    )


def _state(member: Member) -> str:
    if member.standing == "held" and member.report.approach:
        return "docked" if len(member.report.approach) == 1 else "docking"
    if member.standing != "joined":
        return member.standing
    if member.report.free:
        return "free"
    if member.waits_for:
        return "waiting"
    return "driving" if member.ahead or member.report.goal_id else "idle"
