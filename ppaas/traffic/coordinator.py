"""Coordinator of the traffic of a map: reports of robots in, grants out. It has no clock and does no I/O."""

import itertools
import math
from collections.abc import Callable, Iterable

from msgspec.structs import replace

from ppaas.errors import InvalidInput, NotFound, PPaaSError
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.fleet.problem import is_connected
from ppaas.messages.fleet.traffic import MapPoint, TrafficGrants, TrafficReport
from ppaas.traffic.grants import GrantWriter, window_of
from ppaas.traffic.holders import Holders
from ppaas.traffic.members import Arrival, Cell, Member, reached_by
from ppaas.traffic.plan_ahead import PlanAhead
from ppaas.traffic.settings import TrafficParameters

GATHER = 1.0
"""Time in which a new coordinator listens to reports, before it chooses its epoch [s]."""

RETRY = 0.5
"""Time after which the plan is tried to be extended again, if nobody got on by it [s]."""

NEAR = 0.75
"""Largest distance of a goal from the cell that is taken for it, as a part of the distance between two cells."""

LARGEST, FASTEST, FARTHEST, LONGEST = 5.0, 10.0, 20.0, 1000
"""Limits of what a robot may report: its radius [m], speed [m/s], braking distance [m], and number of cells."""

ASIDE = frozenset({"stopped", "silent", "stray"})
"""Standings of robots that are obstacles with what they hold."""

MakeRoadmap = Callable[[float, TrafficParameters], MetricRoadmap]
"""Called with the radius of the largest robot [m] and the margins; returns the roadmap of the map for it."""


class Coordinator:
    """Grants robots cells in the order of one plan, so that no two are in one cell, and none waits for ever.

    A robot that is granted a cell keeps it until it has left it or gives it back. Cells are granted in the order of a
    plan that is extended while robots drive (`PlanAhead`): a robot is granted the next cell once all who enter it
    earlier in the plan have left it. Late robots so delay others, and never meet them (an action dependency graph:
    Hönig et al., "Persistent and Robust Execution of MAPF Schedules in Warehouses", 2019).

    Parameters
    ----------
    make_roadmap : callable
        Returns the roadmap for robots of a radius.
    parameters : TrafficParameters
    epoch : int
        Epoch that the coordinator before this one had; 0 for none.
    now : float
        Time at which it begins [s]; all other times are by the same clock.
    """

    def __init__(
        self, make_roadmap: MakeRoadmap, parameters: TrafficParameters, epoch: int = 0, now: float = 0.0
    ) -> None:
        self.parameters = parameters
        self.members: dict[str, Member] = {}
        self.epoch = epoch
        self.goals = 0
        self._make_roadmap = make_roadmap
        self._radius = 0.0
        self._map: MetricRoadmap | None = None
        self._holders = Holders(self.members)
        self._plan: PlanAhead | None = None
        self._seeds = itertools.count()
        self._writer = GrantWriter()
        self._granting = False
        self._begin = now + GATHER
        self._outdated = True
        self._blocked: dict[Cell, float] = {}
        self._plan_at = now
        self._gives_back: set[str] = set()

    @property
    def spacing(self) -> float:
        """Distance of neighbouring cells [m]; 0 before there is a robot."""
        return 0.0 if self._map is None else self._map.spacing

    def centre(self, cell: Cell) -> tuple[float, float]:
        """Return the centre of a cell [m]."""
        assert self._map is not None, "there are no cells before there is a robot"
        return self._map.centre(cell)

    def known(self) -> list[TrafficReport]:
        """Return the newest report of each robot; its way leads over all cells that it may be granted soon."""
        return [replace(each.report, way=self._may_hold(each), ahead=0) for each in self.members.values()]

    def _may_hold(self, member: Member) -> list[MapPoint]:
        planned = [cell for cell in member.queue if not isinstance(cell, Arrival)]
        return [MapPoint(*self.centre(cell)) for cell in [*sorted(member.base), *member.chain, *planned]]

    # -- reports -------------------------------------------------------------------------------------------------------

    def report(self, report: TrafficReport, now: float) -> None:
        """Take a report of a robot; one that is older than another is ignored.

        Raises
        ------
        InvalidInput
            A number is not finite, or the counts do not fit each other; nothing is changed.
        """
        _check(report)
        member = self.members.get(report.robot)
        before = report if member is None else member.report
        if member is None:
            member = self._join(report, now)
        elif report.header.stamp.seconds() <= member.report.header.stamp.seconds():
            return
        elif report.revision != member.report.revision or report.free or member.report.free:
            self._begin_anew(member, report)
        elif report.epoch > self.epoch or not self._is_ours(member):
            self._adopt(member, report)
        member.report, member.heard_at = report, now
        if report.epoch > self.epoch:
            self._outrank(report.epoch, now)
        self._advance(member, before, now)
        self._note_standing(member, now)

    def take_out(self, name: str) -> None:
        """Take a robot out of the traffic: what it holds is free, and nobody waits for it.

        Raises
        ------
        NotFound
            There is no such robot in the traffic.
        """
        member = self._member(name)
        member.standing = "out"
        self._release(member)
        self._outdated = True

    def put_back(self, name: str) -> None:
        """Let a robot that was taken out take part again, where it stands.

        Raises
        ------
        NotFound
            There is no such robot in the traffic.
        """
        member = self._member(name)
        if member.standing == "out":
            member.standing, member.tries = "joined", 0
            self._stand(member)
            self._gives_back.add(name)

    def _member(self, name: str) -> Member:
        if name not in self.members:
            raise NotFound("robot of the traffic", name, sorted(self.members))
        return self.members[name]

    def _is_ours(self, member: Member) -> bool:
        return member.report.epoch == self.epoch

    def _join(self, report: TrafficReport, now: float) -> Member:
        member = Member(report, now, moved_at=now, goal_since=now)
        self.members[report.robot] = member
        self._use_radius(report.radius)
        if report.way:
            self._adopt(member, report)
        else:
            self._stand(member)
            self._stop_around(member)
        return member

    def _use_radius(self, radius: float) -> None:
        """Use a roadmap for a larger robot than those before; all ways begin anew."""
        if self._map is not None and radius <= self._radius:
            return
        self._radius = max(radius, self._radius)
        self._change_roadmap()

    def use_map(self, make_roadmap: MakeRoadmap) -> None:
        """Go on with another version of the map; all ways begin anew."""
        self._make_roadmap = make_roadmap
        if self._map is not None:
            self._change_roadmap()

    def _change_roadmap(self) -> None:
        self._map = self._make_roadmap(self._radius, self.parameters)
        self._blocked.clear()
        for member in self.members.values():
            self._holders.let_all_go(member.name)
        for member in self.members.values():
            if member.report.way:
                self._adopt(member, member.report)
                self._gives_back.add(member.name)
            elif member.standing != "out":
                self._stand(member)
        self._outdated = True

    def _stand(self, member: Member) -> None:
        """Let a robot hold the cells that it touches, and nothing else."""
        assert self._map is not None
        self._release(member)
        report = member.report
        if not report.free and member.standing != "out":
            member.base = set(self._map.touched(report.x, report.y, report.radius))
        for cell in member.base:
            self._holders.hold(member.name, cell)
        self._outdated = True

    def _stop_around(self, member: Member) -> None:
        """Ask robots that were granted cells which a robot that has just come touches to give them back."""
        self._gives_back |= {name for cell in member.base for name in self._holders[cell]} - {member.name}

    def _release(self, member: Member) -> None:
        member.base, member.chain, member.first = set(), [], 0
        member.queue.clear()
        member.aim = ""
        self._holders.let_all_go(member.name)

    def _begin_anew(self, member: Member, report: TrafficReport) -> None:
        member.report = report
        self._gives_back.discard(member.name)
        self._stand(member)

    def _adopt(self, member: Member, report: TrafficReport) -> None:
        """Take the way that a robot reports for what it holds: it is that of another coordinator."""
        assert self._map is not None
        member.report = report
        self._stand(member)
        for point in report.way:
            cell = self._map.closest(point.x, point.y)
            member.chain.append(cell)
            self._holders.hold(member.name, cell)
        member.first = report.first

    def _outrank(self, epoch: int, now: float) -> None:
        """Begin another epoch, after that of another coordinator; nothing is granted until all robots know of it."""
        self.epoch = epoch
        self._granting, self._begin = False, now + GATHER

    def _advance(self, member: Member, before: TrafficReport, now: float) -> None:
        report = member.report
        if report.revision == before.revision:
            while member.first < report.first and len(member.chain) > 1:
                cell = member.chain.pop(0)
                member.first += 1
                self._holders.let_go(member.name, cell)
        if member.base and member.chain and member.reached > 0:
            base, member.base = member.base, set()
            for cell in base:
                self._holders.let_go(member.name, cell)
        same = report.revision == before.revision
        gets_on = same and reached_by(report) > reached_by(before)
        if gets_on or not same or member.ahead == 0 or before.ahead == 0:
            member.moved_at = now
        if gets_on:
            member.tries = 0
        if report.goal_id != before.goal_id:
            self.goals += bool(before.goal_id) and member.at_goal
            member.goal_since = now - report.goal_seconds
            member.refused = ("", "")

    def _note_standing(self, member: Member, now: float) -> None:
        """Note whether a robot is off its way, or what it found in it."""
        if member.standing == "out":
            return
        if member.report.stray != (member.standing == "stray"):
            member.standing = "stray" if member.report.stray else "joined"
            self._outdated = True
        if member.standing == "silent":
            member.standing, self._outdated = "joined", True
        for point in member.report.blocked:
            self._block(member, point, now + self.parameters.keep_blocked)

    def _block(self, member: Member, point: MapPoint, until: float) -> None:
        """Plan around a cell in which a robot found something; the robot itself does not drive there."""
        assert self._map is not None
        cell = self._map.closest(point.x, point.y)
        self._outdated |= cell not in self._blocked
        self._blocked[cell] = until
        if cell in member.chain:
            self._gives_back.add(member.name)

    # -- steps ---------------------------------------------------------------------------------------------------------

    def step(self, now: float) -> list[TrafficGrants]:
        """Watch robots, plan, and grant; return what is to be sent."""
        self._watch(now)
        if self._map is None:
            return []
        if not self._granting:
            return self._gather(now)
        if not self._let_alone():
            self._plan_ways(now)
            self._grant(now)
        return self._writer.due(self._messages(now), now)

    def _watch(self, now: float) -> None:
        p = self.parameters
        for member in tuple(self.members.values()):
            silent = now - member.heard_at
            if silent > p.forget:
                self._release(member)
                del self.members[member.name]
                self._outdated = True
            elif member.standing == "joined" and silent > p.patience:
                self._set_aside(member, "silent", now)
            elif member.standing == "joined" and now - member.moved_at > p.patience:
                self._set_aside(member, "stopped", now)
            elif member.standing == "stopped" and now >= member.retry_at and not member.ahead:
                member.standing, member.moved_at, self._outdated = "joined", now, True
        for cell in [cell for cell, until in self._blocked.items() if now >= until]:
            del self._blocked[cell]
            self._outdated = True

    def _set_aside(self, member: Member, standing: str, now: float) -> None:
        """Count a robot as an obstacle with all that it holds; ask it to give back what it is not on."""
        member.standing = "silent" if standing == "silent" else "stopped"
        member.retry_at = now + self.parameters.retry * 2.0 ** min(member.tries, 3)
        member.tries += 1
        self._gives_back.add(member.name)
        self._outdated = True

    def _gather(self, now: float) -> list[TrafficGrants]:
        """Listen to the robots; then choose an epoch, and begin once each of them knows of it or says nothing."""
        if now < self._begin:
            return []
        if self._begin != float("-inf"):
            self.epoch, self._begin = self.epoch + 1, float("-inf")
        known = all(
            self._is_ours(member) or now - member.heard_at > self.parameters.silence for member in self.members.values()
        )
        self._granting = known
        return self._writer.due(self._messages(now), now)

    def _let_alone(self) -> bool:
        """Return whether no robot may be granted cells, since one drives freely."""
        present = [member for member in self.members.values() if member.standing != "out"]
        return len(present) == 1 or any(member.report.free for member in present)

    # -- the plan ------------------------------------------------------------------------------------------------------

    def _plan_ways(self, now: float) -> None:
        if self._outdated:
            self._plan_anew()
        plan = self._plan
        if plan is None:
            return
        for member in self._planned(plan):
            self._head_for_goal(plan, member)
        if now >= self._plan_at and not plan.extend():
            self._plan_at = now + RETRY

    def _planned(self, plan: PlanAhead) -> Iterable[Member]:
        return [member for member in self.members.values() if member.name in plan]

    def _plan_anew(self) -> None:
        """Plan from the ends of all ways; those who do not take part are obstacles."""
        assert self._map is not None
        self._outdated = False
        heads = self._heads()
        blocked = set(self._blocked)
        for member in self.members.values():
            member.queue.clear()
            member.aim = member.no_way = ""
            if member.name not in heads:
                blocked |= member.held
        roadmap = self._map.roadmap.without(blocked - set(heads.values()))
        self._plan = plan = PlanAhead(roadmap, heads, self.members, next(self._seeds)) if heads else None
        for name, cell in heads.items():
            if plan is not None and not self.members[name].chain:
                plan.enter_first(self.members[name], cell)

    def _heads(self) -> dict[str, Cell]:
        """Return the cells at the ends of ways; robots without a way get the nearest cell that nobody else has."""
        assert self._map is not None
        joined = [member for member in self.members.values() if member.standing == "joined"]
        heads = {member.name: member.chain[-1] for member in joined if member.chain}
        taken = set(heads.values())
        for member in joined:
            if not member.chain:
                report = member.report
                near = self._map.nearby(report.x, report.y, 2.0 * self._map.spacing)
                free = [cell for cell in near if cell not in taken and not self._is_granted(cell, member.name)]
                if free:
                    heads[member.name] = free[0]
                    taken.add(free[0])
        return heads

    def _is_granted(self, cell: Cell, but: str) -> bool:
        return any(cell in self.members[name].chain for name in self._holders[cell] - {but})

    def _head_for_goal(self, plan: PlanAhead, member: Member) -> None:
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
        self._aim(plan, member)

    def _aim(self, plan: PlanAhead, member: Member) -> None:
        assert self._map is not None
        goal_id, goal = member.report.goal_id, member.report.goal
        try:
            cell = self._map.nearest(goal.x, goal.y, NEAR * self._map.spacing)
        except PPaaSError as error:
            member.refused = goal_id, f"robots of the traffic cannot stand there: {error}"
            return
        member.aim = goal_id
        if plan.aim(member, cell):
            return
        member.no_way = goal_id
        if member.chain and not is_connected(self._map.roadmap, member.chain[-1], cell):
            member.refused = goal_id, "there is no way to it for the robots of the traffic"
            return
        holders = [name for name in self._holders[cell] if self.members[name].standing in ASIDE]
        if holders:
            member.refused = goal_id, f"robot {holders[0]} stands on it and does not move"

    # -- grants --------------------------------------------------------------------------------------------------------

    def _grant(self, now: float) -> None:
        plan = self._plan
        if plan is None:
            return
        for member in sorted(self._planned(plan), key=lambda each: each.goal_since):
            if not self._may_be_granted(member, now):
                continue
            why = ""
            while not why and member.ahead < window_of(member.report, self.spacing):
                why = self._grant_next(plan, member)
            self._wait(member, why if member.ahead == 0 else "", now)

    def _may_be_granted(self, member: Member, now: float) -> bool:
        silent = now - member.heard_at > self.parameters.silence
        return self._is_ours(member) and not silent and member.name not in self._gives_back

    def _grant_next(self, plan: PlanAhead, member: Member) -> str:
        """Grant a robot the next cell of its plan; return why not, if it is not."""
        assert self._map is not None
        if not member.queue:
            return "a way" if member.report.goal_id else "nothing"
        cell = member.queue[0]
        if isinstance(cell, Arrival):
            return "its goal"
        before = plan.turn_of(cell)
        if before != member.name:
            return before
        other = self._holders.in_the_way(member, cell, self._map.centre(cell))
        if other:
            return other
        plan.entered(member, cell)
        member.chain.append(cell)
        self._holders.hold(member.name, cell)
        return ""

    @staticmethod
    def _wait(member: Member, why: str, now: float) -> None:
        why = "" if why in {"nothing", "its goal"} else why
        if bool(why) != bool(member.waits_for):
            member.waits_since = now if why else float("inf")
        member.waits_for = why

    def _messages(self, now: float) -> Iterable[tuple[Member, TrafficGrants]]:
        alone = self._granting and sum(each.standing != "out" for each in self.members.values()) == 1
        for member in self.members.values():
            report = member.report
            way = [MapPoint(*self._map.centre(cell)) for cell in member.chain] if self._map is not None else []
            yield member, TrafficGrants(
                report.header, member.name, self.epoch, member.number, report.revision, self.spacing,
                first=member.first, way=way, at_goal=member.at_goal and self._granting,
                goal_id=report.goal_id if self._leads_to_goal(member) else "",
                free=alone or member.standing == "out",
                give_back=self._gives_back_now(member, alone=alone),
                waits_for=member.waits_for,
                refused=member.refused[1] if member.refused[0] == report.goal_id else "",
            )  # fmt: skip

    @staticmethod
    def _leads_to_goal(member: Member) -> bool:
        goal_id = member.report.goal_id
        return bool(member.aim) or Arrival(goal_id) in member.queue or member.refused[0] == goal_id

    def _gives_back_now(self, member: Member, *, alone: bool) -> bool:
        if member.report.free:
            return not alone and member.standing != "out"
        return member.name in self._gives_back


def _check(report: TrafficReport) -> None:
    """Raise ``InvalidInput`` if a report cannot be used."""
    points = [*report.way, *report.blocked, report.goal]
    numbers = [report.x, report.y, report.theta, report.goal_seconds, *(c for each in points for c in (each.x, each.y))]
    sizes = [report.radius, report.speed, report.braking]
    if not all(map(math.isfinite, numbers + sizes)):
        raise InvalidInput(f"a number in the report of robot {report.robot!r} is not finite")
    if min(sizes) < 0.0 or report.radius > LARGEST or not 0.0 < report.speed <= FASTEST or report.braking > FARTHEST:
        raise InvalidInput(f"the radius, speed or braking distance of robot {report.robot!r} is out of range")
    if min(report.epoch, report.grants, report.revision, report.first) < 0 or not 0 <= report.ahead <= len(report.way):
        raise InvalidInput(f"the numbers of the way of robot {report.robot!r} do not fit each other")
    if len(report.way) > LONGEST or len(report.blocked) > LONGEST:
        raise InvalidInput(f"robot {report.robot!r} reports a way of more than {LONGEST} cells")
