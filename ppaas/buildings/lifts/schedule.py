"""Schedule of a car: robots of one direction share it, and each second that one has waited counts for it."""

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from ppaas.buildings.building import Building, LiftSettings
from ppaas.buildings.lifts.states import LiftRide

ROBOT_TIME = 8.0
"""Time that a robot takes through the doors of a car [s], of which costs are computed."""

AGEING = 60.0
"""Time after which the weight of a robot that waits has doubled [s]."""

AGED = 180.0
"""Time after which a robot that waits is fetched before all others [s]."""

MIN_STEP = 3.0
"""Height taken for a storey of a building that states no elevations [m]."""


@dataclass(frozen=True, slots=True)
class Shaft:
    """A lift as its schedule sees it.

    Parameters
    ----------
    levels : mapping of str to float
        Height of each floor [m].
    settings : LiftSettings
    aged : float
        Time after which a robot that waits is fetched before all others [s].
    """

    levels: Mapping[str, float]
    settings: LiftSettings
    aged: float = AGED

    def direction(self, ride: LiftRide) -> int:
        """Return 1 for a ride upwards, else -1."""
        return 1 if self.levels[ride.destination] > self.levels[ride.origin] else -1

    def seconds(self, start: str, end: str) -> float:
        """Return the time of a drive between two floors, with the doors closed before and opened after it [s]."""
        if start == end:
            return self.settings.doors
        return abs(self.levels[end] - self.levels[start]) / self.settings.speed + 2.0 * self.settings.doors

    def batch(self, waiting: Iterable[LiftRide], room: int) -> list[LiftRide]:
        """Return the rides that have room in the car together, the oldest first."""
        chosen = []
        for ride in sorted(waiting, key=_age):
            if ride.size <= room:
                chosen.append(ride)
                room -= ride.size
        return chosen


@dataclass(frozen=True, slots=True)
class CarStop:
    """Next stop of a car.

    Parameters
    ----------
    floor : str
    direction : int
        Direction of the robots that board there: 1 up, -1 down, 0 for none.
    """

    floor: str
    direction: int = 0


def levels_of(building: Building) -> dict[str, float]:
    """Return the height of each floor [m]; floors of one elevation, as where none is given, are in their order."""
    listed = sorted(enumerate(building.floors), key=lambda item: (item[1].elevation, item[0]))
    levels: dict[str, float] = {}
    height = -math.inf
    for _, floor in listed:
        height = floor.elevation if floor.elevation > height else height + MIN_STEP
        levels[floor.name] = height
    return levels


def next_stop(
    shaft: Shaft, at: str, riders: Sequence[LiftRide], waiting: Sequence[LiftRide], now: float
) -> CarStop | None:
    """Return where a car drives next; None if nobody needs it.

    Parameters
    ----------
    shaft : Shaft
    at : str
        Floor where it is.
    riders, waiting : sequence of LiftRide
        Robots in the car, and those that may board.
    now : float
    """
    if riders:
        return _onwards(shaft, at, riders, waiting, now)
    groups: defaultdict[CarStop, list[LiftRide]] = defaultdict(list)
    for ride in waiting:
        groups[CarStop(ride.origin, shaft.direction(ride))].append(ride)
    if not groups:
        return None
    if is_any_aged(shaft, waiting, now):
        oldest = min(waiting, key=_age)
        return CarStop(oldest.origin, shaft.direction(oldest))
    return max(
        groups, key=lambda stop: (_worth(shaft, at, stop.floor, groups[stop], now), -shaft.seconds(at, stop.floor))
    )


def heading(shaft: Shaft, at: str, riders: Sequence[LiftRide]) -> int:
    """Return the direction in which a car with robots drives on: the way of the one that rides longest."""
    for ride in sorted(riders, key=_age):
        height = shaft.levels[ride.destination] - shaft.levels[at]
        if height:
            return 1 if height > 0.0 else -1
    return 0


def is_any_aged(shaft: Shaft, waiting: Iterable[LiftRide], now: float) -> bool:
    """Return whether a robot has waited so long that it is fetched before all others."""
    return any(now - ride.since > shaft.aged for ride in waiting)


def _onwards(shaft: Shaft, at: str, riders: Sequence[LiftRide], waiting: Sequence[LiftRide], now: float) -> CarStop:
    """Return the nearest stop ahead: a destination, or a robot of this direction on the way for which there is room."""
    direction = heading(shaft, at, riders)
    room = shaft.settings.robots - sum(ride.size for ride in riders)
    here = shaft.levels[at]
    ahead = {
        ride.destination: CarStop(ride.destination, direction)
        for ride in riders
        if (shaft.levels[ride.destination] - here) * direction >= 0.0
    }
    # An old one that waits elsewhere is served sooner if the car collects nobody.
    if not is_any_aged(shaft, waiting, now):
        ahead |= {
            ride.origin: CarStop(ride.origin, direction)
            for ride in waiting
            if ride.size <= room
            and shaft.direction(ride) == direction
            and (shaft.levels[ride.origin] - here) * direction > 0.0
        }
    return min(ahead.values(), key=lambda stop: abs(shaft.levels[stop.floor] - here))


def _worth(shaft: Shaft, at: str, floor: str, group: Sequence[LiftRide], now: float) -> float:
    """Return the weight of robots that a trip serves, over the time that it takes [1/s]."""
    batch = shaft.batch(group, shaft.settings.robots)
    if not batch:
        return 0.0
    stops = sorted({ride.destination for ride in batch}, key=lambda name: abs(shaft.levels[name] - shaft.levels[floor]))
    seconds = shaft.seconds(at, floor) + 2.0 * ROBOT_TIME * len(batch)
    for start, end in zip([floor, *stops], stops, strict=False):
        seconds += shaft.seconds(start, end)
    return sum(1.0 + max(now - ride.since, 0.0) / AGEING for ride in batch) / seconds


def _age(ride: LiftRide) -> tuple[float, str]:
    return ride.since, ride.robot
