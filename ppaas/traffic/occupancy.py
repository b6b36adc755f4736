"""Occupancy: the robots of the traffic, the cells that each holds, and who is an obstacle."""

from collections.abc import Collection, Sequence

from msgspec.structs import replace

from ppaas.costmap.moving_obstacles import MovingObstacle
from ppaas.errors import NotFound
from ppaas.fleet.cell_rules import CellRules, rules_on
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.messages.fleet.traffic import MapPoint, TrafficReport
from ppaas.traffic.approaches import touched_by
from ppaas.traffic.holders import Holders, spur_to
from ppaas.traffic.members import (
    ASIDE,
    FRESH,
    Arrival,
    Cell,
    Kind,
    Member,
    Outsiders,
    Standing,
    check_report,
    reached_by,
)  # fmt: skip
from ppaas.traffic.settings import TrafficParameters
from ppaas.traffic.sizes import CellsOfSizes, MakeRoadmap
from ppaas.zones.zone import Lane, OneWay, Zone

GIVEN_UP = 3
"""Number of times that a robot does not get on before goals on which it stands are refused."""


class Occupancy:
    """What robots have reported, and what they hold.

    Parameters
    ----------
    make_roadmap : callable
        Returns the roadmap for robots of some radii.
    parameters : TrafficParameters

    Attributes
    ----------
    members : dict of str to Member
        Robots by name.
    holders : Holders
    outdated : bool
        Whether the plan has to be remade, since who takes part or what is blocked has changed.
    gives_back : set of str
        Robots that should give back the rest of their ways.
    goals : int
        Number of goals reached.
    outsiders : Outsiders
        Robots that take no part, and people.
    """

    def __init__(self, make_roadmap: MakeRoadmap, parameters: TrafficParameters) -> None:
        self.parameters = parameters
        self.members: dict[str, Member] = {}
        self.holders = Holders(self.members)
        self.outdated = True
        self.gives_back: set[str] = set()
        self.goals = 0
        self._layout = CellsOfSizes(make_roadmap, parameters)
        self._zones: Sequence[Zone] = []
        self._rules: CellRules | None = None
        self._blocked: dict[Cell, float] = {}
        self.outsiders = Outsiders()

    @property
    def blocked(self) -> Collection[Cell]:
        """Cells in which something was found that holds none."""
        return self._blocked.keys()

    @property
    def map(self) -> MetricRoadmap | None:
        """Cells of the map; None before there is a robot, and while the map has no cells for those that there are."""
        return self._layout.map

    @property
    def cells(self) -> MetricRoadmap:
        """Cells of the map; there is a robot."""
        assert self.map is not None, "there are no cells before there is a robot"
        return self.map

    def size_of(self, member: Member) -> int:
        """Return the size of a robot, by which cells are barred for it."""
        return self.cells.size_of(member.report.radius)

    @property
    def rules(self) -> CellRules:
        """Rules of the zones in force, on the cells of the map; there is a robot."""
        assert self._rules is not None, "there are no rules before there is a robot"
        return self._rules

    @property
    def has_lanes(self) -> bool:
        """True if a zone in force says along which lines, or in which direction, robots drive."""
        return any(isinstance(zone.rule, Lane | OneWay) for zone in self._zones)

    def inside(self, area: int) -> set[str]:
        """Return the robots that hold a cell of an area."""
        areas_of = self.rules.areas_of
        return {name for name, each in self.members.items() if any(area in areas_of(cell) for cell in each.held)}

    @property
    def present(self) -> list[Member]:
        """Robots that no operator has taken out."""
        return [member for member in self.members.values() if member.standing != "out"]

    def known(self) -> list[TrafficReport]:
        """Return the newest report of each robot; its way leads over all cells that it may be granted soon."""
        return [replace(each.report, way=self._may_hold(each), ahead=0, spur=[]) for each in self.members.values()]

    def _may_hold(self, member: Member) -> list[MapPoint]:
        planned = [cell for cell in member.queue if not isinstance(cell, Arrival)]
        aside = set() if member.spur is None else member.spur.cells
        cells = [*sorted(member.base | aside), *member.chain, *planned]
        return [MapPoint(*self.cells.centre(cell)) for cell in cells]

    # -- reports -------------------------------------------------------------------------------------------------------

    def report(self, report: TrafficReport, now: float, epoch: int) -> bool:
        """Take a report of a robot; return False if it is older than another.

        Parameters
        ----------
        report : TrafficReport
        now : float
            Time [s].
        epoch : int
            Epoch whose grants are known here; of another, the robot knows better what it holds.

        Raises
        ------
        InvalidInput
            A number is not finite, or the counts do not fit each other; nothing is changed.
        """
        check_report(report)
        member = self.members.get(report.robot)
        before = report if member is None else member.report
        if member is None:
            member = self._join(report, now)
        elif member.note_late(report, now):
            return False
        elif report.revision != before.revision or report.free or before.free:
            self._begin_anew(member, report)
        elif report.epoch != epoch or before.epoch != epoch or member.restored:
            self._adopt(member, report)
        member.take(report, before, now)
        if (report.aside or member.misfit) and member.base != self._touched(member):
            self._follow(member, now) if report.aside else self._stand(member)
        self._advance(member, before, now)
        self._note_goal(member, before, now)
        self._note_standing(member, now)
        return True

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
        self.outdated = True

    def put_back(self, name: str) -> None:
        """Take a robot that was taken out in again, where it stands; raises as ``take_out``."""
        member = self._member(name)
        if member.standing == "out":
            member.standing, member.tries = "joined", 0
            self._stand(member)
            self.gives_back.add(name)

    def let_go(self, name: str) -> None:
        """Forget a robot that has left the map, if it is known; it may return, and reports itself then."""
        if name in self.members:
            self._release(self.members.pop(name))
            self.outdated = True

    def _member(self, name: str) -> Member:
        if name not in self.members:
            raise NotFound("robot of the traffic", name, sorted(self.members))
        return self.members[name]

    def _join(self, report: TrafficReport, now: float) -> Member:
        """Take a robot in; all ways restart on another roadmap if it is of another size for which that differs."""
        member = Member(report, now, moved_at=now, goal_since=now - report.goal_seconds)
        before = self.map
        if report.radius not in self._layout.radii or self.map is None:
            member.misfit = self._make_room(report.radius)
        self.members[report.robot] = member
        if report.way and not member.misfit:
            self._adopt(member, report)
            self.gives_back |= {member.name} if self.map is not before else set()
        else:
            self._stand(member)
        if not report.way:
            self._stop_around(member)
        return member

    def use_map(self, make_roadmap: MakeRoadmap) -> None:
        """Go on with another version of the map; all ways restart.

        Nobody drives if it has no cells for the robots.
        """
        before = self.map
        self._layout.use(make_roadmap)
        if self.map is not None:
            self._change_roadmap(self.map)
        elif before is not None:
            self._lose_roadmap()
        for member in self.members.values():
            if member.misfit or self.map is None:
                member.misfit = self._make_room(member.report.radius)

    def use_zones(self, zones: Sequence[Zone]) -> None:
        """Go on with these zones in force; robots drive on to the ends of what they were granted."""
        if zones == self._zones:
            return
        self._zones = zones
        if self.map is not None:
            self._rules = rules_on(self.map, zones, self._layout.radii[-1])
            self.outdated = True

    def _make_room(self, radius: float) -> str:
        """Make cells as robots of a radius need them; return why it has none, if so."""
        before = self.map
        misfit = self._layout.make_room(radius, self.members.values())
        if self.map is not before:
            self._change_roadmap(self.cells)
        return misfit

    def _change_roadmap(self, cells: MetricRoadmap) -> None:
        self._rules = rules_on(cells, self._zones, self._layout.radii[-1])
        self._blocked.clear()
        for member in self.members.values():
            if member.report.way and not member.misfit:
                self._adopt(member, member.report)
                self.gives_back.add(member.name)
            elif member.standing != "out":
                self._stand(member)
        self.outdated = True

    def _lose_roadmap(self) -> None:
        self._rules = None
        self._blocked.clear()
        for member in self.members.values():
            self._release(member)
            self.gives_back |= {member.name} if member.report.way else set()

    def _stand(self, member: Member) -> None:
        """Mark only the cells that a robot touches as held by it."""
        self._release(member)
        member.base = self._touched(member)
        for cell in member.base:
            self.holders.hold(member.name, cell)
        self.outdated = True

    def _follow(self, member: Member, now: float) -> None:
        """Mark what a robot touches that is aside, and ask others for it; plan around its place now and then."""
        due = member.is_due(now, anyway=self.outdated)
        self._stand(member)
        self._stop_around(member)
        self.outdated = due

    def _touched(self, member: Member) -> set[Cell]:
        """Return the cells that a robot touches, and one that is aside until it stands; none if it drives freely."""
        at = member.report
        if self.map is None or at.free or member.standing == "out":
            return set()
        return touched_by(self.map, at, self.parameters.margin)

    def _stop_around(self, member: Member) -> None:
        """Ask robots that were granted cells which a robot touches, where it begins, to give them back."""
        for cell in member.base:
            self.gives_back |= {name for name in self.holders[cell] if cell in self.members[name].chain}

    def _release(self, member: Member) -> None:
        member.base, member.chain, member.first = set(), [], 0
        member.spur = None
        member.queue.clear()
        member.aim = member.decided = ""
        self.holders.let_all_go(member.name)

    def _begin_anew(self, member: Member, report: TrafficReport) -> None:
        if report.radius != member.report.radius:  # it has taken up a load, or set one down
            member.misfit = self._make_room(report.radius)
        member.report = report
        self.gives_back.discard(member.name)
        self._stand(member)
        self._stop_around(member)

    def _adopt(self, member: Member, report: TrafficReport) -> None:
        """Take the way that a robot reports for what it holds: it comes from another coordinator."""
        member.report = report
        self._stand(member)
        if member.standing == "out" or self.map is None:
            return
        for point in report.way:
            cell = self.cells.closest(point.x, point.y)
            member.chain.append(cell)
            self.holders.hold(member.name, cell)
        member.first = report.first
        for place in report.spur:
            member.decided = report.goal_id if place == report.goal else ""  # it may lead to an earlier goal
            self.holders.hold_spur(member, spur_to(self.cells, member, place, member.decided))

    def _advance(self, member: Member, before: TrafficReport, now: float) -> None:
        report = member.report
        if report.revision == before.revision:
            while member.first < report.first and len(member.chain) > 1:
                cell = member.chain.pop(0)
                member.first += 1
                self.holders.let_go(member.name, cell)
        if member.base and member.chain and member.reached > 0:
            base, member.base = member.base, set()
            for cell in base:
                self.holders.let_go(member.name, cell)
        same = report.revision == before.revision
        gets_on = same and reached_by(report) > reached_by(before)
        if gets_on or not same or ((member.ahead == 0 or before.ahead == 0) and not member.is_recalled):
            member.moved_at = now
        if gets_on and reached_by(report) > 1:  # it is in another cell than where it stood
            member.tries = 0

    def _note_goal(self, member: Member, before: TrafficReport, now: float) -> None:
        report = member.report
        if report.goal_id != before.goal_id:
            self.goals += bool(before.goal_id) and member.at_goal
            member.goal_since = now - report.goal_seconds
            member.refused = ("", "")

    def _note_standing(self, member: Member, now: float) -> None:
        """Note whether a robot is aside or off its way, or what it found in it."""
        if member.standing == "out":
            return
        standing: Standing = "stray" if member.report.stray and not member.report.aside else ASIDE[member.report.aside]
        if member.standing != standing and (standing != "joined" or member.standing in {"stray", "by_hand", "held"}):
            member.standing, self.outdated = standing, True
        if member.standing == "silent":
            member.standing, self.outdated = "joined", True
        for point in [] if self.map is None else member.report.blocked:
            self._block(member, point, now + self.parameters.keep_blocked)

    def _block(self, member: Member, point: MapPoint, until: float) -> None:
        """Plan around a cell in which a robot found something; the robot itself does not drive there."""
        cell = self.cells.closest(point.x, point.y)
        self.outdated |= cell not in self._blocked
        self._blocked[cell] = until
        if cell in member.chain:
            self.gives_back.add(member.name)

    def see_others(self, kind: Kind, seen: Sequence[MovingObstacle], now: float) -> None:
        """Take the positions of all robots on the map, of which some take no part in the traffic, or of people."""
        if self.map is not None:
            self.outsiders.see(kind, seen, self.members.values(), self.map, now)

    def is_given_up(self, name: str) -> bool:
        """Return whether a robot does not get on, although it was tried again."""
        member = self.members[name]
        return member.standing in {"stopped", "silent"} and member.tries >= GIVEN_UP

    # -- who takes part ------------------------------------------------------------------------------------------------

    def watch(self, now: float) -> None:
        """Set robots aside that do not get on or say nothing, try them again, and forget what is long ago."""
        p = self.parameters
        for member in tuple(self.members.values()):
            silent = now - member.heard_at
            if silent > p.forget:
                self.let_go(member.name)
            elif member.standing == "joined" and silent > p.patience:
                self._set_aside(member, "silent", now)
            elif member.standing == "joined" and now - member.moved_at > p.patience:
                self._set_aside(member, "stopped", now)
            elif member.standing == "stopped" and now >= member.retry_at and not member.ahead:
                member.standing, member.moved_at, self.outdated = "joined", now, True
            elif member.is_displaced:
                self.outdated |= member.is_due(now, anyway=self.outdated)
        for cell in self.outsiders.staying(p.patience, now):
            self.outdated |= cell not in self._blocked
            self._blocked[cell] = now + FRESH
        for cell in [cell for cell, until in self._blocked.items() if now >= until]:
            del self._blocked[cell]
            self.outdated = True

    def _set_aside(self, member: Member, standing: Standing, now: float) -> None:
        """Count a robot as an obstacle with all that it holds; ask it to give back what it is not on."""
        member.standing = standing
        member.retry_at = now + self.parameters.retry * 2.0 ** min(member.tries, 3)
        member.tries += 1
        self.gives_back.add(member.name)
        self.outdated = True
