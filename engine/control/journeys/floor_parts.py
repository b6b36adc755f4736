"""Parts of the maps of floors that robots compare their scans with after a ride."""

from collections.abc import Mapping

from msgspec.structs import replace

from ppaas.bounded import BoundedDict
from ppaas.buildings.journeys.places import landing_of
from ppaas.buildings.journeys.records import Journey
from ppaas.buildings.layout import BuildingLayout, Landing, Place
from ppaas.buildings.riding.car_frame import carried
from ppaas.buildings.riding.floor_maps import clear_of, part_around
from ppaas.errors import InvalidMap, NotFound
from ppaas.geometry import Pose2D
from ppaas.maps.formats.map_files import open_grid
from ppaas.messages.fleet.floors import FindFloorRequest, FloorPart
from ppaas.messages.geometry_msgs import Pose
from storage.ports import MapStore
from storage.versions import IMAGE, YAML

KEPT = 200
"""Largest number of parts that are kept, for the next rides."""

MOST_FLOORS = 16
"""Largest number of floors that a robot compares its scans with: the nearest to the one that the lift has
named."""

LOOK = 8.0
"""Time after which the clone answers although the floor is not known [s]."""


class FloorParts:
    """Parts of the maps around the lifts of all buildings.

    Parameters
    ----------
    maps : MapStore
    """

    def __init__(self, maps: MapStore) -> None:
        self._maps = maps
        self._kept: BoundedDict[tuple[object, ...], FloorPart] = BoundedDict(KEPT)

    def of(self, journey: Journey, layout: BuildingLayout) -> dict[str, FloorPart]:
        """Return the part of the map of each floor at which the lift of a journey stops, by its name; may block.

        Floors without a map are left out, and in a high building those far from the one that the lift has named.
        """
        leg, zero = journey.now, layout.building.floor(journey.out).elevation
        landings = {landing.floor: landing for landing in layout.landings[leg.name]}
        ridden = {leg.floor, leg.to_floor, journey.on}
        heights = {name: abs(layout.building.floor(name).elevation - zero) for name in landings}
        near = sorted(landings, key=lambda name: (name not in ridden, heights[name]))
        found = {}
        for name in near[:MOST_FLOORS]:
            try:
                found[name] = self._part(layout, landings[name])
            except (NotFound, InvalidMap):
                continue
        return found

    def _part(self, layout: BuildingLayout, landing: Landing) -> FloorPart:
        floor = layout.building.floor(landing.floor)
        key = floor.map, self._maps.map_head(floor.map).version, floor.name, floor.elevation, landing.car
        part = self._kept.get(key)
        if part is None:
            with self._maps.open_map(floor.map, only=(YAML, IMAGE)) as opened:
                part = part_around(open_grid(*opened.grid()), Pose2D(*landing.car), floor.name, floor.elevation)
            self._kept[key] = part
        return part


def floor_request(
    journey: Journey, layout: BuildingLayout, parts: Mapping[str, FloorPart], pose: Place | None, now: float
) -> FindFloorRequest:
    """Return what the clone of a robot is asked that leaves the car.

    Parameters
    ----------
    journey : Journey
    layout : BuildingLayout
    parts : mapping of str to FloorPart
        Parts of the maps of floors, by name.
    pose : Place, optional
        Pose of the robot on the map of its clone, if it is known.
    now : float
        Time [s since the epoch].

    Raises
    ------
    NotFound
        There are no two maps to compare, or none of the floor that the robot leaves on or has come from.
    """
    leg = journey.now
    if not {journey.on, leg.floor, leg.to_floor} <= parts.keys():
        raise NotFound("map around the lift of floor", journey.on, list(parts))
    here, none = landing_of(layout, leg, journey.on), Pose2D(0.0, 0.0)
    floors = [
        replace(part, change=Pose.of(carried(layout.building, here, landing_of(layout, leg, floor), none)))
        for floor, part in parts.items()
    ]
    seconds = max(now - journey.pressure_at, 0.0) if journey.pressure else 0.0
    clear = 0.0 if journey.phase == "looking" else clear_of(here, None if pose is None else Pose2D(*pose))
    return FindFloorRequest(leg.floor, leg.to_floor, journey.out, floors, journey.pressure, seconds, clear, LOOK)
