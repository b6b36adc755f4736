"""Places of a journey: where its robot drives to in each phase, and where it is on the map of another floor."""

import math

from ppaas.buildings.journeys.records import Journey, JourneyLeg
from ppaas.buildings.layout import BuildingLayout, Landing
from ppaas.buildings.riding.car_frame import carried, is_inside, places_in_car
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.tasks.records import Place


def find_landing(layout: BuildingLayout, leg: JourneyLeg, floor: str) -> Landing | None:
    """Return the landing of the lift of a leg on a floor; the door that it takes there, if there are two."""
    found = [each for each in layout.landings.get(leg.name, ()) if each.floor == floor]
    ends = [place for place, on in ((leg.start, leg.floor), (leg.goal, leg.to_floor)) if on == floor]
    return min(found, key=lambda each: _apart(each.wait, ends), default=None)


def landing_of(layout: BuildingLayout, leg: JourneyLeg, floor: str) -> Landing:
    """Return what ``find_landing`` returns, of a leg that was planned on this layout."""
    found = find_landing(layout, leg, floor)
    assert found is not None, "legs are planned on this layout"
    return found


def _apart(wait: Place, ends: list[Place]) -> float:
    return min((math.hypot(wait[0] - x, wait[1] - y) for x, y, _ in ends), default=0.0)


def outside(landing: Landing) -> Place:
    """Return the place before the door of a landing, with the heading of a robot that has left the car."""
    x, y, yaw = landing.wait
    return x, y, wrap_angle(yaw + math.pi)


def target_of(journey: Journey, layout: BuildingLayout, seen: Pose2D | None) -> Place:
    """Return where a robot drives to in the phase of its journey.

    Parameters
    ----------
    journey : Journey
    layout : BuildingLayout
    seen : Pose2D, optional
        Pose of the robot on the map of the floor that its clone is on, if it is known.
    """
    leg = journey.now
    if journey.phase == "boarding":
        places = places_in_car(layout.building, layout.landings[leg.name], landing_of(layout, leg, leg.floor))
        x, y, yaw = places[min(journey.place, len(places) - 1)]
        return x, y, yaw
    if journey.phase not in ("alighting", "looking"):
        return leg.goal
    out = leg.goal if journey.out == leg.to_floor else outside(landing_of(layout, leg, journey.out))
    if journey.found or journey.phase == "alighting":
        return out
    x, y, yaw = out if seen is None else seen
    return x, y, wrap_angle(yaw + 0.5 * math.pi)  # where it is, turned to look round


def pose_on(floor: str, journey: Journey, layout: BuildingLayout, seen: Pose2D | None) -> Place:
    """Return the pose of the robot on the map of a floor to which its clone goes; parameters as for ``target_of``."""
    leg = journey.now
    if leg.kind == "way":
        x, y, yaw = leg.goal
        return x - leg.length * math.cos(yaw), y - leg.length * math.sin(yaw), yaw
    origin = landing_of(layout, leg, journey.on)
    if journey.phase == "looking":
        here = seen or Pose2D(*outside(origin))
    else:
        here = seen if seen is not None and is_inside(origin, seen) else Pose2D(*origin.car)
    pose = carried(layout.building, origin, landing_of(layout, leg, floor), here)
    return pose.x, pose.y, pose.theta
