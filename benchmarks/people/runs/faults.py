"""Bad input of robots: what goes wrong with the reports of robot r1 on their way to the coordinator."""

import math
from collections.abc import Callable

import msgspec

from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import PeopleReport
from ppaas.messages.people_msgs import PositionMeasurement

ROBOT, OTHER = "r1", "r2"
"""The robot that has a fault, and the other one that has it where there are two."""
BEGIN = 20.0
"""Simulated time after which faults begin [s], so that the coordinator has met the robots before."""
DISAGREE = (0.6, 0.8)
"""Error of the position of a robot that disagrees with the others [m]: 1 m."""
SET_OFF = 0.5
"""Error of clocks [s]."""
PERIOD = 10.0
"""Time between two changes of the ids of people [s]."""

Fault = Callable[[PeopleReport, float], list[PeopleReport]]
"""Returns the reports that arrive in place of one that is sent at a simulated time [s]."""


def none(report: PeopleReport, _now: float) -> list[PeopleReport]:
    """Return the report."""
    return [report]


def disagrees(report: PeopleReport, now: float) -> list[PeopleReport]:
    """Put the robot 1 m beside its position, and just as sure of it as before."""
    if now < BEGIN:
        return [report]
    at = report.pose.pose.position
    moved = msgspec.structs.replace(at, x=at.x + DISAGREE[0], y=at.y + DISAGREE[1])
    pose = msgspec.structs.replace(report.pose, pose=msgspec.structs.replace(report.pose.pose, position=moved))
    return [msgspec.structs.replace(report, pose=pose)]


def lies(report: PeopleReport, now: float) -> list[PeopleReport]:
    """Add three people who stand around the robot, and leave out those whom it sees."""
    if now < BEGIN:
        return [report]
    told = [_person(report, f"9{n}", 1.5 * math.cos(a), 1.5 * math.sin(a)) for n, a in enumerate((-0.4, 0.0, 0.4))]
    return [msgspec.structs.replace(report, people=told)]


def leaves(report: PeopleReport, now: float) -> list[PeopleReport]:
    """Send nothing any more."""
    return [report] if now < BEGIN else []


class Freezes:
    """Send the same report for ever, with its old stamp."""

    def __init__(self) -> None:
        self._last: PeopleReport | None = None

    def __call__(self, report: PeopleReport, now: float) -> list[PeopleReport]:
        """Return the frozen report."""
        if now < BEGIN or self._last is None:
            self._last = report
        return [self._last]


def sends_nan(report: PeopleReport, now: float) -> list[PeopleReport]:
    """Make a position of each second report not a number: of a person if there is one, else of the robot."""
    if now < BEGIN or round(now * 5.0) % 2:
        return [report]
    bad = Point(math.nan, 0.0, 0.0)
    if report.people:
        people = [msgspec.structs.replace(report.people[0], pos=bad), *report.people[1:]]
        return [msgspec.structs.replace(report, people=people)]
    pose = msgspec.structs.replace(report.pose, pose=msgspec.structs.replace(report.pose.pose, position=bad))
    return [msgspec.structs.replace(report, pose=pose)]


def reuses_ids(report: PeopleReport, now: float) -> list[PeopleReport]:
    """Give the people new ids from 1 on every ten seconds, in the reverse order of the last time."""
    if now < BEGIN:
        return [report]
    people = sorted(report.people, key=lambda person: person.object_id, reverse=int(now / PERIOD) % 2 == 1)
    renamed = [
        msgspec.structs.replace(person, object_id=str(number), name=f"{report.robot}/{number}")
        for number, person in enumerate(people, 1)
    ]
    return [msgspec.structs.replace(report, people=renamed)]


def clocks(report: PeopleReport, _now: float) -> list[PeopleReport]:
    """Set the clock of the robot ahead, and that of another one behind."""
    off = SET_OFF if report.robot == ROBOT else -SET_OFF
    header = Header(stamp=Time.of(report.header.stamp.seconds() + off), frame_id=report.header.frame_id)
    people = [msgspec.structs.replace(person, header=header) for person in report.people]
    return [msgspec.structs.replace(report, header=header, people=people)]


def _person(report: PeopleReport, number: str, x: float, y: float) -> PositionMeasurement:
    covariance = [0.01, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0, 0.01]
    return PositionMeasurement(report.header, f"{report.robot}/{number}", number, Point(x, y, 1.2), 0.9, covariance)


REPORT_FAULTS: dict[str, Callable[[], Fault]] = {
    "disagree": lambda: disagrees, "lies": lambda: lies, "leaves": lambda: leaves, "freezes": Freezes,
    "nan": lambda: sends_nan, "ids": lambda: reuses_ids, "clocks": lambda: clocks,
}  # fmt: skip
"""Faults of reports by their names."""

MIRRORS = "mirrors"
"""Fault of the place: mirrors on its walls, which depth cameras see people in."""

DOUBTFUL = ("disagree", "lies", "freezes", "leaves", "nan")
"""Faults in which people whom only the robot sees may be counted, and need not be."""


def fault_of(name: str) -> Fault:
    """Return the fault of a name, which changes the reports of the robots that have it alone; none for another name."""
    make = REPORT_FAULTS.get(name)
    if make is None:
        return none
    fault, whose = make(), (ROBOT, OTHER) if name == "clocks" else (ROBOT,)
    return lambda report, now: fault(report, now) if report.robot in whose else [report]
