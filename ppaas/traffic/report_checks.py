"""Checks of what robots report to the traffic."""

import math

from ppaas.errors import InvalidInput
from ppaas.messages.fleet.traffic import TrafficReport

LARGEST, FASTEST, FARTHEST, LONGEST = 5.0, 10.0, 20.0, 1000
"""Limits of what a robot may report: its radius [m], speed [m/s], braking distance [m], and number of cells."""


def check_report(report: TrafficReport) -> None:
    """Raise ``InvalidInput`` if a report cannot be used."""
    points = [*report.way, *report.blocked, report.goal, *report.spur]
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
    if len(report.spur) > 1 or (report.spur and not _is_beside(report)):
        raise InvalidInput(f"robot {report.robot!r} reports a spur that does not begin at the end of its way")


def _is_beside(report: TrafficReport) -> bool:
    """Return whether the spur of a robot ends near to the last cell of its way."""
    if not report.way:
        return False
    (place,), last = report.spur, report.way[-1]
    return math.hypot(place.x - last.x, place.y - last.y) <= LARGEST
