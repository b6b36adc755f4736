"""Approaches: straight ways on which robots dock and undock, granted as a whole once nobody else is there."""

import itertools
from collections.abc import Iterable

from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.messages.fleet.traffic import MapPoint, TrafficReport
from ppaas.traffic.members import Cell, Member, Outsiders


def touched_by(cells: MetricRoadmap, report: TrafficReport, margin: float) -> set[Cell]:
    """Return the cells that a robot holds where it stands, with those of its approach.

    Parameters
    ----------
    cells : MetricRoadmap
    report : TrafficReport
    margin : float
        Distance that a robot may be off its approach [m].
    """
    x, y, radius = report.x, report.y, report.radius
    if not report.approach:  # one that is aside may need its braking distance until it stands
        return set(cells.touched(x, y, radius + (report.braking if report.aside else 0.0)).tolist())
    found = set(cells.touched(x, y, radius).tolist())
    for (ax, ay), (bx, by) in itertools.pairwise((point.x, point.y) for point in report.approach):
        found |= cells.touched_along((ax, ay), (bx, by), radius + margin)
    return found


def approach_of(
    member: Member, members: Iterable[Member], cells: MetricRoadmap, outsiders: Outsiders, now: float
) -> tuple[list[MapPoint], str]:
    """Return the approach that a robot is granted, or whom it waits for.

    Of two whose approaches cross, the one that stands in the other's way goes first, or else the one that asked first.
    """
    approach = member.report.approach
    if len(approach) < 2 or member.standing == "out":
        return [], ""
    for other in members:
        shared = other.held & member.base if other is not member else set()
        if shared and not _waits_for(other, member, shared, cells):
            return [], other.name
    outside = next((who for cell in sorted(member.base) if (who := outsiders.in_cell(cell, now))), "")
    member.docks |= not outside
    return ([], outside) if outside else (approach, "")


def _waits_for(other: Member, member: Member, shared: set[Cell], cells: MetricRoadmap) -> bool:
    """Return whether a robot waits with its approach until another has docked or undocked."""
    if len(other.report.approach) < 2 or other.docks or shared & _standing(other, cells):
        return False
    asked_first = (member.asked_at, member.name) < (other.asked_at, other.name)
    return member.docks or asked_first or bool(shared & _standing(member, cells))


def _standing(member: Member, cells: MetricRoadmap) -> set[Cell]:
    return set(cells.touched(member.report.x, member.report.y, member.report.radius).tolist())
