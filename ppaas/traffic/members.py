"""Members of the traffic, with checks of what they report, and outsiders, who take no part in it."""

import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Literal

from ppaas.costmap.moving_obstacles import MovingObstacle
from ppaas.errors import InvalidInput
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.messages.fleet.traffic import MapPoint, TrafficReport
from ppaas.traffic.room_in_cells import Line

# -- members of the traffic --------------------------------------------------------------------------------------------

Cell = int

Standing = Literal["joined", "stopped", "stray", "by_hand", "held", "silent", "out"]
"""Standing of a member: planned for; or an obstacle, because it does not get on, left its way, is driven by hand, is
stopped, says nothing, or an operator took it out."""

ASIDE: dict[str, Standing] = {"": "joined", "by_hand": "by_hand", "held": "held"}
"""Standing of a robot by what it reports as ``aside``."""


CLOCK_SET = 2.5
"""Time for which all reports of a robot are older than one before, after which its clock was set back [s]. Reports that
are late are followed sooner by one that is not."""


AROUND = 2.0
"""Shortest time between two plans around a robot that is driven by hand through the cells [s]."""


@dataclass(frozen=True, slots=True)
class Arrival:
    """Mark in the queue of a robot: it has to end its goal before it drives on."""

    goal_id: str


@dataclass(slots=True)
class Spur:
    """Straight way of a robot from the centre of its last cell to its goal, where it touches other cells.

    Attributes
    ----------
    place : MapPoint
        Its end [m].
    goal_id : str
    cells : frozenset of int
        Cells that the robot touches on it.
    line : tuple
        Both ends of it [m].
    ended_by : int
        Number of the grants by which the robot was ordered to drive back; 0 if it was not.
    """

    place: MapPoint
    goal_id: str
    cells: frozenset[Cell]
    line: Line
    ended_by: int = 0


@dataclass(slots=True)
class Member:
    """A robot of the traffic.

    Attributes
    ----------
    report : TrafficReport
        Its newest report.
    heard_at : float
        Time of that [s].
    standing : Standing
    misfit : str
        Why there are no cells for it, and it is an obstacle where it stands; empty if they are as wide as it needs.
    base : set of int
        Cells that it touches where its way began, until it has reached the first cell of the way.
    chain : list of int
        Cells of its way that it holds, in order.
    first : int
        Number of the first cell of ``chain`` within the revision.
    spur : Spur or None
        Way beside the last cell of ``chain`` that it was granted.
    decided : str
        Id of the goal of which it is decided where in its cell or beside it the robot stops.
    settles : tuple of str and float
        Id of a goal, and the time from which it does not wait for a spur to it [s].
    queue : deque of int or Arrival
        Planned cells after the chain, and the ends of goals.
    aim : str
        Id of the goal that is planned for; empty if none is.
    moved_at : float
        Time at which it last got on, or had nowhere to go [s].
    tries : int
        Number of times that it was given up since it last got on.
    retry_at : float
        Time at which one that does not get on is tried again [s].
    waits_for : str
        Why nothing more is granted.
    waits_since : float
        Time at which it began to wait [s].
    goal_since : float
        Time from which its goal is open [s].
    refused : tuple of str
        Id of a goal that cannot be reached, and why.
    no_way : str
        Id of a goal to which this plan has no way.
    restored : bool
        Whether it is only known from a checkpoint: it may hold less than it is taken to hold.
    followed_at : float
        Time at which others were last planned around the place of a robot that is aside [s].
    is_displaced : bool
        Whether it touches other cells than then.
    asked_at : float
        Time at which it asked for its approach [s].
    docks : bool
        Whether it was granted that.
    late_since : float
        Time from which on all of its reports were older than one before; infinite if the last was not [s].
    """

    report: TrafficReport
    heard_at: float
    standing: Standing = "joined"
    misfit: str = ""
    base: set[Cell] = field(default_factory=set)
    chain: list[Cell] = field(default_factory=list)
    first: int = 0
    spur: Spur | None = None
    decided: str = ""
    settles: tuple[str, float] = ("", 0.0)
    queue: "deque[Cell | Arrival]" = field(default_factory=deque)
    aim: str = ""
    moved_at: float = 0.0
    tries: int = 0
    retry_at: float = float("inf")
    waits_for: str = ""
    waits_since: float = float("inf")
    goal_since: float = 0.0
    refused: tuple[str, str] = ("", "")
    no_way: str = ""
    restored: bool = False
    followed_at: float = float("-inf")
    is_displaced: bool = False
    asked_at: float = float("inf")
    docks: bool = False
    late_since: float = float("inf")

    @property
    def name(self) -> str:
        """Robot ID."""
        return self.report.robot

    @property
    def held(self) -> set[Cell]:
        """Cells that it holds."""
        return self.base.union(self.chain, () if self.spur is None else self.spur.cells)

    @property
    def is_recalled(self) -> bool:
        """True if it has to drive back from its spur."""
        return self.spur is not None and self.spur.ended_by > 0

    def take(self, report: TrafficReport, before: TrafficReport, now: float) -> None:
        """Take the newest report, after another."""
        self.report, self.heard_at, self.restored = report, now, False
        if report.approach != before.approach:
            self.asked_at, self.docks = now, False

    def note_late(self, report: TrafficReport, now: float) -> bool:
        """Note whether a report is older than the newest one, and return it.

        If all are for `CLOCK_SET`, the clock was set back that they are stamped by: then they are as new as any.
        """
        if report.header.stamp.seconds() > self.report.header.stamp.seconds():
            self.late_since = float("inf")
            return False
        self.late_since = min(self.late_since, now)
        if now - self.late_since < CLOCK_SET:
            return True
        self.late_since = float("inf")
        return False

    def is_due(self, now: float, *, anyway: bool) -> bool:
        """Return whether to plan around a robot that is aside, every `AROUND` at most or anyway; note it."""
        due = anyway or now - self.followed_at >= AROUND
        self.is_displaced = not due
        self.followed_at = now if due else self.followed_at
        return due

    @property
    def at_goal(self) -> bool:
        """True if its way ends in the cell of its goal, which it has to end now."""
        return bool(self.queue) and isinstance(self.queue[0], Arrival)

    @property
    def ahead(self) -> int:
        """Number of cells of its way that it has not reached, by its newest report."""
        return self.first + len(self.chain) - self.reached

    @property
    def reached(self) -> int:
        """Number of cells of its way that it has reached, by its newest report."""
        return reached_by(self.report)


def reached_by(report: TrafficReport) -> int:
    """Return the number of cells of its way that a robot has reached by a report."""
    return report.first + len(report.way) - report.ahead


# -- checks of what robots report to the traffic -----------------------------------------------------------------------

LONGEST_APPROACH = 20.0
"""Largest distance of a robot from the ends of its approach [m]."""

LARGEST, FASTEST, FARTHEST, LONGEST = 5.0, 10.0, 20.0, 1000
"""Limits of what a robot may report: its radius [m], speed [m/s], braking distance [m], and number of cells."""


def check_report(report: TrafficReport) -> None:
    """Raise ``InvalidInput`` if a report cannot be used."""
    points = [*report.way, *report.blocked, report.goal, *report.spur, *report.approach]
    numbers = [report.x, report.y, report.theta, report.goal_seconds, *(c for each in points for c in (each.x, each.y))]
    sizes = [report.radius, report.speed, report.braking, report.tolerance]
    if not all(map(math.isfinite, numbers + sizes)):
        raise InvalidInput(f"a number in the report of robot {report.robot!r} is not finite")
    if min(sizes) < 0.0 or report.radius > LARGEST or not 0.0 < report.speed <= FASTEST or report.braking > FARTHEST:
        raise InvalidInput(f"a size, speed or distance of robot {report.robot!r} is out of range")
    if min(report.epoch, report.grants, report.revision, report.first) < 0 or not 0 <= report.ahead <= len(report.way):
        raise InvalidInput(f"the numbers of the way of robot {report.robot!r} do not fit each other")
    if len(report.way) > LONGEST or len(report.blocked) > LONGEST:
        raise InvalidInput(f"robot {report.robot!r} reports a way of more than {LONGEST} cells")
    far = max((math.hypot(each.x - report.x, each.y - report.y) for each in report.approach), default=0.0)
    if len(report.approach) > 2 or far > LONGEST_APPROACH or (report.approach and not report.aside):
        raise InvalidInput(f"robot {report.robot!r} reports an approach that is none")
    if report.aside not in ASIDE:
        raise InvalidInput(f"robot {report.robot!r} is aside for an unknown reason, {report.aside[:32]!r}")
    if len(report.spur) > 1 or (report.spur and not _is_beside(report)):
        raise InvalidInput(f"robot {report.robot!r} reports a spur that does not begin on its way")


def _is_beside(report: TrafficReport) -> bool:
    """Return whether the spur of a robot ends near to its way; that may lead on already while the robot drives back."""
    [place] = report.spur
    return any(math.hypot(place.x - cell.x, place.y - cell.y) <= LARGEST for cell in report.way)


# -- outsiders ---------------------------------------------------------------------------------------------------------

FRESH = 1.0
"""Age up to which the positions of outsiders are used [s]."""

ITSELF = 0.3
"""Distance from the position that a robot of the traffic reports within which another one is that robot [m]."""

Kind = Literal["a robot outside of the traffic", "a person"]
"""Kind of an outsider, in the words for robots that wait for it."""

ROBOT: Kind = "a robot outside of the traffic"
PERSON: Kind = "a person"


class Outsiders:
    """Cells that outsiders touch, and for how long they have."""

    def __init__(self) -> None:
        self._since: dict[Kind, dict[Cell, float]] = {}
        self._seen_at: dict[Kind, float] = {}

    def see(
        self, kind: Kind, seen: Sequence[MovingObstacle], members: Iterable[Member], cells: MetricRoadmap, now: float
    ) -> None:
        """Note where all robots on the map are now, of which the robots of the traffic are left out, or all people.

        Parameters
        ----------
        kind : {"a robot outside of the traffic", "a person"}
        seen : sequence of MovingObstacle
            With a margin around each, in the map frame.
        members : iterable of Member
            Robots of the traffic.
        cells : MetricRoadmap
        now : float
            Time [s].
        """
        known = [(member.report.x, member.report.y) for member in members] if kind == ROBOT else []
        before, since = self._since.get(kind, {}), dict[Cell, float]()
        for one in seen:
            if all(math.hypot(one.x - x, one.y - y) > ITSELF for x, y in known):
                for cell in cells.touched(one.x, one.y, one.radius).tolist():
                    since[cell] = before.get(cell, now)
        self._since[kind], self._seen_at[kind] = since, now

    def in_cell(self, cell: Cell, now: float) -> str:
        """Return what is in a cell; empty if no outsider is."""
        return next((kind for kind in self._fresh(now) if cell in self._since[kind]), "")

    def staying(self, patience: float, now: float) -> list[Cell]:
        """Return the cells in which an outsider has been for a time [s]."""
        found = (self._since[kind].items() for kind in self._fresh(now))
        return [cell for cells in found for cell, since in cells if now - since > patience]

    def _fresh(self, now: float) -> list[Kind]:
        return [kind for kind, seen_at in self._seen_at.items() if now - seen_at <= FRESH]
