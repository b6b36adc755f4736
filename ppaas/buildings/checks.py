"""Checks of a building that need its layout: floors that cannot be reached, and anchors that do not agree."""

import math
from collections.abc import Iterator

from ppaas.buildings.building import Building
from ppaas.buildings.layout import BuildingLayout, Landing, Place

MOST_APART = 0.5
"""Distance between the cars of a lift on two floors, in the frame of the building, up to which anchors agree [m]."""


def warnings_of(layout: BuildingLayout) -> tuple[str, ...]:
    """Return what may be wrong in a building: the warnings of its layout, and what this module finds."""
    return (*layout.warnings, *_unreachable(layout), *_apart(layout))


def reachable_floors(layout: BuildingLayout, floor: str) -> frozenset[str]:
    """Return the floors that lifts and ways join to a floor, it among them; one-way ways count in both directions."""
    stops = [{each.floor for each in places} for places in layout.landings.values()]
    joined = [*stops, *({end.floor for end in ends} for ends in layout.ways.values())]
    found: set[str] = {floor}
    while more := [floors for floors in joined if floors & found and not floors <= found]:
        found.update(*more)
    return frozenset(found)


def in_building(building: Building, floor: str, place: Place) -> Place:
    """Return a pose on the map of a floor in the frame of the building."""
    x, y, yaw = building.floor(floor).anchor
    along, across, heading = place
    cos, sin = math.cos(yaw), math.sin(yaw)
    turned = math.remainder(yaw + heading, math.tau)
    return x + cos * along - sin * across, y + sin * along + cos * across, turned


def _unreachable(layout: BuildingLayout) -> Iterator[str]:
    first = layout.building.floors[0].name
    reached = reachable_floors(layout, first)
    for floor in layout.building.floors:
        if floor.name not in reached:
            yield f"floor {floor.name!r} cannot be reached from {first!r}: no lift and no way leads there"


def _apart(layout: BuildingLayout) -> Iterator[str]:
    for lift, landings in layout.landings.items():
        of_floors = {landing.floor: landing for landing in landings}
        first, *others = (_car(layout.building, landing) for landing in of_floors.values())
        begin, *floors = of_floors
        for floor, (x, y) in zip(floors, others, strict=True):
            apart = math.hypot(x - first[0], y - first[1])
            if apart > MOST_APART:
                yield (
                    f"lift {lift!r}: its car on floor {floor!r} is {apart:.2f} m from where it is on {begin!r}; "
                    f"check the anchor of {floor!r}, and where the car is drawn"
                )


def _car(building: Building, landing: Landing) -> tuple[float, float]:
    x, y, _ = in_building(building, landing.floor, landing.car)
    return x, y
