"""Controller of the doors of a building, for all of its robots: events in, orders out.

Nothing of it is stored. A door that is held closes by itself within 10 s after the last request. So robots that were at
a door when a controller was killed ask again, and the door stays open for them if they do so in time.
"""

from collections.abc import Collection, Iterable
from dataclasses import dataclass, field

from ppaas.buildings.doors.states import DoorAlert, DoorOrder, DoorRequest, DoorState, Pass
from ppaas.buildings.lifts.states import Refuse, Wait

HEARTBEAT = 1.0
"""Time between two requests to stay open [s]."""

SILENT = 5.0
"""Age of the last state of a door from which it counts as silent [s]."""

GONE, NO_RADIO = 8.0, 90.0
"""Time after which a robot that is not connected is forgotten: before the door, and while it passes [s]."""

NO_OPENING = 30.0
"""Time after which a door that has not opened is given up [s]."""

STUCK = 30.0
"""Time in a doorway after which people are called [s]."""

DoorKey = tuple[str, str]
"""Floor, and name of a door there."""


@dataclass(slots=True)
class _Passage:
    """Robot at a door.

    Parameters
    ----------
    since : float
        When it asked, or began to pass.
    told : Pass or Wait, optional
        Its last order.
    """

    since: float
    told: Pass | Wait | None = None
    lost: float | None = None
    is_reported: bool = False

    @property
    def passes(self) -> bool:
        return isinstance(self.told, Pass)


@dataclass(slots=True)
class _Door:
    key: DoorKey
    session: str
    state: DoorState | None = None
    heard: float = float("-inf")
    robots: dict[str, _Passage] = field(default_factory=dict)
    asked: DoorRequest | None = None
    asked_at: float = float("-inf")

    def fault(self, now: float) -> str:
        name = f"door {self.key[1]!r} of floor {self.key[0]!r}"
        if self.state is None or now - self.heard > SILENT:
            return f"{name} reports nothing"
        return f"{name} is {self.state.mode}" if self.state.mode in ("offline", "unknown") else ""


class DoorController:
    """State machine of the doors of a building that have devices. Its methods are events; they return orders.

    Parameters
    ----------
    owner : str
        Name of the building in sessions, which no other controller of its doors has.
    doors : iterable of DoorKey
        Doors that are opened by a device; robots pass others as they are.
    """

    def __init__(self, owner: str, doors: Iterable[DoorKey]) -> None:
        self._doors = {key: _Door(key, f"ppaas/{owner}/{key[0]}/{key[1]}") for key in doors}

    @property
    def states(self) -> dict[DoorKey, DoorState | None]:
        """What each door reported last."""
        return {key: door.state for key, door in self._doors.items()}

    def robots_at(self, key: DoorKey) -> tuple[str, ...]:
        """Return the robots for which a door is held open."""
        return tuple(self._doors[key].robots)

    def fault(self, key: DoorKey, now: float) -> str:
        """Return why a door opens for nobody now; empty if it does."""
        return self._doors[key].fault(now)

    def closing(self, key: DoorKey) -> DoorRequest:
        """Return the order by which a door is free to close."""
        return DoorRequest(*key, self._doors[key].session, "closed")

    # -- events --------------------------------------------------------------------------------------------------------

    def approach(self, robot: str, floor: str, door: str, now: float) -> list[DoorOrder]:
        """Note that a robot stands before a door, or nears it; the same event again has its last order repeated."""
        found = self._doors.get((floor, door))
        if found is None:
            return [Pass(robot, floor, door)]
        passage = found.robots.setdefault(robot, _Passage(now))
        passage.told = Pass(robot, floor, door) if passage.passes else None
        again: list[DoorOrder] = [passage.told] if passage.told is not None and self._is_open(found, now) else []
        return again + self._advance(found, now)

    def passed(self, robot: str, floor: str, door: str, now: float) -> list[DoorOrder]:
        """Note that a robot is clear of a door, on either side, or does not want to pass it any more."""
        found = self._doors.get((floor, door))
        if found is None or found.robots.pop(robot, None) is None:
            return []
        return self._advance(found, now)

    def robots_seen(self, robots: Collection[str], now: float) -> list[DoorOrder]:
        """Note the robots that are connected: all of them, each time."""
        for door in self._doors.values():
            for robot, passage in door.robots.items():
                passage.lost = None if robot in robots else now if passage.lost is None else passage.lost
        return self.tick(now)

    def door_state(self, state: DoorState, now: float) -> list[DoorOrder]:
        """Note what a door reports."""
        door = self._doors.get((state.floor, state.door))
        if door is None:
            return []
        door.state, door.heard = state, now
        return self._advance(door, now)

    def tick(self, now: float) -> list[DoorOrder]:
        """Return what follows from the time; call it several times a second."""
        return [order for door in self._doors.values() for order in self._advance(door, now)]

    # -- internals -----------------------------------------------------------------------------------------------------

    def _is_open(self, door: _Door, now: float) -> bool:
        return door.state is not None and door.state.mode == "open" and not door.fault(now)

    def _advance(self, door: _Door, now: float) -> list[DoorOrder]:
        orders = self._give_up(door, now)
        is_open = self._is_open(door, now)
        for robot, passage in door.robots.items():
            order: Pass | Wait
            if is_open:
                order = Pass(robot, *door.key)
            else:
                order = Wait(robot, door.fault(now) or f"door {door.key[1]!r} of floor {door.key[0]!r} is opened")
            # A robot in the doorway of a door that closes goes on: its sensors stop it, and it must not stay there.
            if order != passage.told and not (passage.passes and not is_open):
                if isinstance(order, Pass):
                    passage.since = now
                passage.told = order
                orders.append(order)
        return orders + self._ask(door, now)

    def _give_up(self, door: _Door, now: float) -> list[DoorOrder]:
        orders: list[DoorOrder] = []
        for robot, passage in tuple(door.robots.items()):
            lost = 0.0 if passage.lost is None else now - passage.lost
            if passage.passes and now - passage.since > STUCK and not passage.is_reported:
                passage.is_reported = True
                orders.append(DoorAlert(*door.key, robot, f"robot {robot!r} stands in door {door.key[1]!r}"))
            if lost > (NO_RADIO if passage.passes else GONE):
                orders.append(Refuse(robot, f"robot {robot!r} is not connected any more"))
            elif not passage.passes and now - passage.since > NO_OPENING:
                text = door.fault(now) or f"door {door.key[1]!r} of floor {door.key[0]!r} does not open"
                orders += [Refuse(robot, text), DoorAlert(*door.key, robot, text)]
            else:
                continue
            del door.robots[robot]
        return orders

    def _ask(self, door: _Door, now: float) -> list[DoorOrder]:
        """Repeat the request to stay open while robots are there; let the door close once when none is."""
        request = DoorRequest(*door.key, door.session, "open" if door.robots else "closed")
        is_due = request.mode == "open" and now - door.asked_at >= HEARTBEAT
        if (request == door.asked and not is_due) or (door.asked is None and request.mode == "closed"):
            return []  # a door that was never asked for closes by itself, if an earlier controller held it
        door.asked, door.asked_at = request, now
        return [request]
