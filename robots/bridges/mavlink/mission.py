"""Driving by waypoints: a path of the clone becomes a mission, which the vehicle drives by itself."""

import math
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.maps.georeference import GeoAnchor
from ppaas.messages.nav2_motions import FollowPathError
from ppaas.polygons import Points
from ppaas.wire.vda5050.master.instructions import PathEnded
from robots.bridges.mavlink.authority import AuthorityStep, Given, Hold, SendMessage, VehicleAuthority, switched
from robots.bridges.mavlink.dialect import mavlink
from robots.bridges.mavlink.place import VehicleMotion
from robots.bridges.mavlink.vehicle import ModeChanged, VehicleEvent

PATIENCE, TRIES = 1.0, 5
"""Time for which the vehicle's next request is waited for [s], and how often the last message is sent."""

NEAR = 0.5
"""Distance from the end within which a vehicle that stands has ended its mission [m], as the clone believes it."""

STANDING, STANDS_AFTER = 0.05, 2.0
"""Speed below which a vehicle stands [m/s, rad/s], and time after which it counts [s]."""

STUCK = 60.0
"""Time without progress after which a mission has failed [s]."""

PROGRESS = 0.2
"""Distance by which the rest of the path shrinks if there is progress [m]."""


@dataclass(frozen=True, slots=True)
class PathProgress:
    """Rest of a path [m], speed [m/s], and what the vehicle does in words."""

    path: str
    distance: float
    speed: float
    text: str


MissionStep = AuthorityStep | PathEnded


class Phase(Enum):
    """What becomes of a path."""

    NONE = "no path"
    WAITING = "waiting for the vehicle to stand"
    UPLOADING = "uploading the mission"
    TAKING = "taking the vehicle"
    RUNNING = "driving"


def items_of(points: Points, anchor: GeoAnchor, first: int, target: tuple[int, int]) -> list[Any]:
    """Return the items of a mission along corners.

    Parameters
    ----------
    points : (n, 2) array
        Corners on the map [m].
    anchor : GeoAnchor
    first : int
        Number of the first corner; items before it are copies of it.
    target : (int, int)
        System and component of the vehicle.
    """
    places = [anchor.to_earth(float(x), float(y)) for x, y in points]
    items = []
    for number, (latitude, longitude) in enumerate([places[0]] * first + places):
        items.append(
            mavlink.MAVLink_mission_item_int_message(
                *target, number, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT, mavlink.MAV_CMD_NAV_WAYPOINT,
                int(number == first), 1, 0.0, 0.0, 0.0, math.nan,
                round(latitude * 1e7), round(longitude * 1e7), 0.0, mavlink.MAV_MISSION_TYPE_MISSION,
            )
        )  # fmt: skip
    return items


class MissionDrive:
    """Uploads the mission of a path, has the vehicle drive it, and watches it until its end.

    Parameters
    ----------
    authority : VehicleAuthority
    anchor : GeoAnchor
        Where the map is on the Earth.
    """

    def __init__(self, authority: VehicleAuthority, anchor: GeoAnchor) -> None:
        self.authority, self._anchor = authority, anchor
        self.phase, self._path = Phase.NONE, ""
        self._points: Points = np.empty((0, 2))
        self._items: list[Any] = []
        self._sent: Any = None
        self._sent_at, self._tries = -math.inf, 0
        self._current = 0
        self._motion: VehicleMotion | None = None
        self._stood_since: float | None = None
        self._rest, self._moved_on_at = math.inf, -math.inf

    @property
    def path(self) -> str:
        """Id of the path that the vehicle is to drive; empty if there is none."""
        return self._path

    # -- from the cloud ------------------------------------------------------------------------------------------------

    def follow(self, path: str, points: Points, now: float) -> list[MissionStep]:
        """Have the vehicle drive along corners, the first of which is where it is [m]."""
        if path == self._path:
            return []
        self._path, self.phase = path, Phase.WAITING
        self._points = points[1:] if len(points) > 1 else points
        vehicle, first = self.authority.vehicle, self.authority.vehicle.book.first_item
        self._items = items_of(self._points, self._anchor, first, (vehicle.system, vehicle.component))
        self._current, self._stood_since = first, None
        self._rest, self._moved_on_at = math.inf, now
        return [*self.authority.release(now), *self._next(now)]

    def cancel(self, path: str, now: float) -> list[MissionStep]:
        """Have the vehicle stand, if it drives this path."""
        if path != self._path:
            return []
        self._forget()
        return list(self.authority.release(now))

    def fail(self, reason: str, now: float) -> list[MissionStep]:
        """End the path, if there is one, and have the vehicle stand."""
        if not self._path:
            return []
        return [*self.authority.release(now), self._end(FollowPathError.UNKNOWN, reason)]

    # -- from the vehicle ----------------------------------------------------------------------------------------------

    def take(self, message: Any, now: float) -> list[MissionStep]:
        """Take a message of the vehicle about missions."""
        match message.get_type():
            case "MISSION_REQUEST_INT" | "MISSION_REQUEST" if self.phase is Phase.UPLOADING:
                return self._item(message.seq, now)
            case "MISSION_ACK" if self.phase is Phase.UPLOADING:
                return self._uploaded(message.type, now)
            case "MISSION_CURRENT" if self.phase is Phase.RUNNING:
                self._current = max(self._current, min(message.seq, len(self._items) - 1))
            case "MISSION_ITEM_REACHED" if self.phase is Phase.RUNNING:
                if message.seq >= len(self._items) - 1:
                    return self._arrived(now)
                self._current = max(self._current, message.seq + 1)
        return []

    def happened(self, event: VehicleEvent, now: float) -> list[MissionStep]:
        """Take what has happened to the vehicle."""
        book = self.authority.vehicle.book
        if isinstance(event, ModeChanged):
            if event.after == book.hold and self._is_near_end():
                self.authority.let_go()
                return [self._end(FollowPathError.NONE)]
            if self.phase in (Phase.WAITING, Phase.UPLOADING) and event.after not in (book.hold, book.mission):
                return [self._end(FollowPathError.UNKNOWN, switched(self.authority.vehicle, event.after))]
        return self.given(self.authority.happened(event, now))

    def given(self, steps: list[AuthorityStep]) -> list[MissionStep]:
        """Take what the authority decided; return it, with the end of the path if the vehicle is not the bridge's."""
        found: list[MissionStep] = list(steps)
        for step in steps:
            if isinstance(step, Given) and self._path and self.phase is not Phase.WAITING:
                found.append(self._end(FollowPathError.UNKNOWN, step.reason))
        return found

    def tick(self, motion: VehicleMotion | None, now: float) -> list[MissionStep]:
        """Do what is due, ten times a second."""
        self._motion = motion or self._motion
        steps = self.given(self.authority.advance(now))
        if self.phase is Phase.UPLOADING and now - self._sent_at >= PATIENCE:
            if self._tries >= TRIES:
                steps.append(self._end(FollowPathError.UNKNOWN, "the vehicle does not answer to a mission"))
            else:
                steps += self._send(self._sent, now)
        steps += self._next(now)
        if self.phase is Phase.RUNNING:
            steps += self._watch(now)
        return steps

    def progress(self) -> PathProgress | None:
        """Return how far the vehicle is; None without a path."""
        if not self._path:
            return None
        speed = 0.0 if self._motion is None else self._motion.forward
        return PathProgress(self._path, self._distance(), speed, self.phase.value)

    # -- parts ---------------------------------------------------------------------------------------------------------

    def _next(self, now: float) -> list[MissionStep]:
        """Go on with the path, if the vehicle allows it."""
        if self.phase is Phase.WAITING and self.authority.hold is Hold.NONE:
            self.phase, self._tries = Phase.UPLOADING, 0
            vehicle = self.authority.vehicle
            count = mavlink.MAVLink_mission_count_message(vehicle.system, vehicle.component, len(self._items))
            return self._send(count, now)
        if self.phase is Phase.TAKING and self.authority.drives:
            self.phase, self._moved_on_at = Phase.RUNNING, now
        return []

    def _send(self, message: Any, now: float) -> list[MissionStep]:
        if message is not self._sent:
            self._tries = 0
        self._sent, self._sent_at = message, now
        self._tries += 1
        return [SendMessage(message)]

    def _item(self, number: int, now: float) -> list[MissionStep]:
        return self._send(self._items[number], now) if number < len(self._items) else []

    def _uploaded(self, verdict: int, now: float) -> list[MissionStep]:
        if verdict != mavlink.MAV_MISSION_ACCEPTED:
            entry = mavlink.enums["MAV_MISSION_RESULT"].get(verdict)
            name = entry.name.removeprefix("MAV_MISSION_") if entry is not None else str(verdict)
            return [self._end(FollowPathError.INVALID_PATH, f"the vehicle refuses the mission: {name}")]
        self.phase = Phase.TAKING
        vehicle = self.authority.vehicle
        begin = mavlink.MAVLink_mission_set_current_message(vehicle.system, vehicle.component, vehicle.book.first_item)
        steps = self.given(self.authority.take(vehicle.book.mission, now))
        return [SendMessage(begin), *steps, *self._next(now)]

    def _watch(self, now: float) -> list[MissionStep]:
        """End a path whose end was not reported, and one along which the vehicle does not move on."""
        if self._is_near_end() and self._stands():
            self._stood_since = self._stood_since or now
            if now - self._stood_since >= STANDS_AFTER:
                return self._arrived(now)
        else:
            self._stood_since = None
        rest = self._distance()
        if rest < self._rest - PROGRESS:
            self._rest, self._moved_on_at = rest, now
        if now - self._moved_on_at > STUCK:
            return self.fail(f"the vehicle has not moved on for {STUCK:g} s", now)
        return []

    def _is_near_end(self) -> bool:
        """Return whether the vehicle is near the last corner, to which it was on its way."""
        if self.phase is not Phase.RUNNING or self._motion is None or self._current < len(self._items) - 1:
            return False
        x, y = self._points[-1]
        return self._motion.pose.distance_to(Pose2D(float(x), float(y))) <= NEAR

    def _stands(self) -> bool:
        motion = self._motion
        return motion is not None and max(map(abs, (motion.forward, motion.left, motion.turn))) < STANDING

    def _distance(self) -> float:
        """Return the length of the rest of the path [m]."""
        rest = self._points[max(self._current - self.authority.vehicle.book.first_item, 0) :]
        if self._motion is not None:
            rest = np.concatenate(([[self._motion.pose.x, self._motion.pose.y]], rest))
        return float(np.hypot(*np.diff(rest, axis=0).T).sum())

    def _arrived(self, now: float) -> list[MissionStep]:
        return [*self.authority.release(now), self._end(FollowPathError.NONE)]

    def _end(self, code: FollowPathError, reason: str = "") -> PathEnded:
        ended = PathEnded(self._path, code, reason)
        self._forget()
        return ended

    def _forget(self) -> None:
        self.phase, self._path = Phase.NONE, ""
