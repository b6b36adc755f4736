"""Tracker of the people that one robot sees, by all detectors and their views, and the names it gives them."""

import math
from collections.abc import Collection, Sequence
from dataclasses import replace

import msgspec

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.messages.people_coordination import SensorView
from ppaas.people.tracks.tracker import Detection, LocalTrack, PeopleTracker, TrackerState

# -- views of a robot's detectors --------------------------------------------------------------------------------------

EDGE = 0.1
"""Margin inside the limits of a view, in which people are missed more often [rad, m]."""

BODY = 0.25
"""Half the width of a person who hides another [m]."""


def sees(view: SensorView, robot: Pose2D, x: float, y: float) -> bool:
    """Return whether a point [m] is inside a view, off its edges.

    Parameters
    ----------
    view : SensorView
    robot : Pose2D
        Pose of the robot, in the frame of the point.
    x, y : float
        The point.
    """
    away, bearing = _from(view, robot, x, y)
    wide = view.field_of_view >= 2.0 * math.pi - EDGE or abs(bearing) <= 0.5 * view.field_of_view - EDGE
    return wide and view.range_min + EDGE <= away <= view.range_max - EDGE


def hides(view: SensorView, robot: Pose2D, nearer: tuple[float, float], x: float, y: float) -> bool:
    """Return whether a person at one point hides another from a sensor."""
    away, bearing = _from(view, robot, x, y)
    near, other = _from(view, robot, *nearer)
    return near < away - BODY and abs(wrap_angle(bearing - other)) < math.atan2(BODY, max(near, BODY))


def _from(view: SensorView, robot: Pose2D, x: float, y: float) -> tuple[float, float]:
    """Return the distance of a point from a sensor [m], and its bearing from the axis of the sensor [rad]."""
    sensor = robot @ Pose2D(view.x, view.y, view.yaw)
    off = math.atan2(y - sensor.y, x - sensor.x)
    return math.hypot(x - sensor.x, y - sensor.y), wrap_angle(off - sensor.theta)


# -- tracker of the people that one robot sees, by all of its detectors, in a frame that does not move with it ---------

HELD = 0.5
"""Time for which a person counts as seen after the last detection [s]: detectors miss one now and then."""

OTHERS = 0.5
"""Time after a detection by another detector within which a miss does not count [s]: legs may be behind a table."""

LATE = 0.6
"""Distance within which a late detection is of a person, whose motion since then is added [m]."""

SET_BACK = 1.0
"""Lateness from which the clock of the robot was set back, and all people are forgotten [s]."""

MOST_IDS = 1_000
"""Largest number of ids of other detectors that are remembered."""


class RobotTrackerState(msgspec.Struct):
    """Checkpoint of a `RobotTracker`."""

    tracker: TrackerState
    believed: list[tuple[str, str, int]] = []


class RobotTracker:
    """Tracker of people around a robot.

    Its positions come from the newest detection where there is one, and are predicted otherwise. So the errors of
    successive positions do not depend on each other, as the filter of the coordinator assumes.
    """

    def __init__(self) -> None:
        self._tracker = PeopleTracker()
        self._newest: dict[int, tuple[float, Detection]] = {}
        self._seen_by: dict[int, dict[str, float]] = {}
        self._believed: dict[tuple[str, str], int] = {}

    @property
    def at(self) -> float:
        """Time of the last step [s]."""
        return self._tracker.at

    def step(self, source: str, now: float, found: Sequence[Detection], view: SensorView | None, robot: Pose2D) -> None:
        """Update the tracks by a measurement.

        Parameters
        ----------
        source : str
            Name of the detector.
        now : float
            Time of the measurement [s].
        found : sequence of Detection
            All people that this detector sees.
        view : SensorView, optional
            Where it sees people. Without it, somebody whom it does not report may still be there.
        robot : Pose2D
            Pose of the robot.
        """
        if self._tracker.at - now > SET_BACK:
            self.restart()
        late = max(self._tracker.at - now, 0.0)
        found = [self._moved_on(each, late) for each in found]
        detections = [replace(each, believed=self._believed_id(source, each.id)) for each in found]

        def expected(track: LocalTrack) -> bool:
            return view is not None and not self._others_see(track, source) and self._in_sight(view, robot, track)

        self._tracker.step(now, detections, expected)
        for each, track in zip(found, self._tracker.assigned, strict=True):
            if track:
                self._note(track, source, each)
        self._forget()

    def predict(self, now: float) -> None:
        """Predict the tracks until a time [s] at which nothing was measured."""
        self._tracker.predict(now)

    def seen(self) -> list[LocalTrack]:
        """Return the people whom the robot sees now, at the time of the last step."""
        people = []
        for track in self._tracker.people:
            if self.at - track.last_seen > HELD or track.id not in self._newest:
                continue
            measured_at, newest = self._newest[track.id]
            here = measured_at >= self.at
            x, y = (newest.x, newest.y) if here else (track.x, track.y)
            covariance = newest.covariance if here else track.covariance
            people.append(replace(track, x=x, y=y, covariance=covariance))
        return people

    def tracks(self) -> set[int]:
        """Return the ids of all tracks, also of people who are hidden now."""
        return {track.id for track in self._tracker.tracks}

    def name_by(self, source: str, track: int) -> str:
        """Return the id that a detector keeps for a track; empty if it has none."""
        names = (name for (other, name), known in self._believed.items() if other == source and known == track)
        return next(names, "")

    def restart(self) -> None:
        """Forget all people, since their frame has jumped; ids go on."""
        state = self._tracker.state()
        self._tracker.restore(TrackerState(None, state.next, [], [], [], []))
        self._forget()

    def state(self) -> RobotTrackerState:
        """Return a checkpoint."""
        believed = [(source, name, track) for (source, name), track in self._believed.items()]
        return RobotTrackerState(self._tracker.state(), believed)

    def restore(self, state: RobotTrackerState) -> None:
        """Go on from a checkpoint."""
        self._tracker.restore(state.tracker)
        self._believed = {(source, name): track for source, name, track in state.believed}
        self._newest = {
            track.id: (track.last_seen, Detection(track.x, track.y, track.covariance, track.score))
            for track in self._tracker.tracks
        }

    def _moved_on(self, found: Detection, late: float) -> Detection:
        """Return a late detection where the person is now, by the velocity of the nearest track."""
        if late <= 0.0 or not self._tracker.tracks:
            return found
        nearest = min(self._tracker.tracks, key=lambda track: math.hypot(track.x - found.x, track.y - found.y))
        if math.hypot(nearest.x - found.x, nearest.y - found.y) > LATE:
            return found
        return replace(found, x=found.x + nearest.vx * late, y=found.y + nearest.vy * late)

    def _believed_id(self, source: str, name: str) -> int:
        return self._believed.get((source, name), 0) if name else 0

    def _in_sight(self, view: SensorView, robot: Pose2D, track: LocalTrack) -> bool:
        others = (other for other in self._tracker.people if other is not track)
        return sees(view, robot, track.x, track.y) and not any(
            hides(view, robot, (other.x, other.y), track.x, track.y) for other in others
        )

    def _others_see(self, track: LocalTrack, source: str) -> bool:
        seen = self._seen_by.get(track.id, {})
        return any(self.at - at <= OTHERS for other, at in seen.items() if other != source)

    def _note(self, track: int, source: str, found: Detection) -> None:
        self._newest[track] = self.at, found
        self._seen_by.setdefault(track, {})[source] = self.at
        if found.id:
            self._believed.pop((source, found.id), None)
            self._believed[source, found.id] = track
            if len(self._believed) > MOST_IDS:
                self._believed.pop(next(iter(self._believed)))

    def _forget(self) -> None:
        kept = {track.id for track in self._tracker.tracks}
        self._newest = {track: newest for track, newest in self._newest.items() if track in kept}
        self._seen_by = {track: seen for track, seen in self._seen_by.items() if track in kept}
        self._believed = {key: track for key, track in self._believed.items() if track in kept}


# -- Torso IDs ---------------------------------------------------------------------------------------------------------

MOST = 200
"""Number of Torso IDs that are used in turn: listeners of ``tf`` keep every frame that they have heard of."""


class TorsoIds:
    """Torso ID of each track."""

    def __init__(self) -> None:
        self._names: dict[int, str] = {}
        self._next = 1

    def of(self, track: int, wanted: str = "", taken: Collection[str] = ()) -> str:
        """Return the Torso ID of a track, which is the same as long as the track exists.

        Parameters
        ----------
        track : int
            Id of the track.
        wanted : str
            Torso ID that the robot itself gave, which a new track gets if no other has it.
        taken : collection of str
            Torso IDs of frames that the robot publishes itself.
        """
        if track not in self._names:
            used = {*self._names.values(), *taken}
            self._names[track] = wanted if wanted and wanted not in self._names.values() else self._new(used)
        return self._names[track]

    def keep(self, tracks: Collection[int]) -> None:
        """Forget the Torso IDs of all other tracks."""
        self._names = {track: name for track, name in self._names.items() if track in tracks}

    def state(self) -> tuple[int, dict[int, str]]:
        """Return a checkpoint."""
        return self._next, dict(self._names)

    def restore(self, state: tuple[int, dict[int, str]]) -> None:
        """Go on from a checkpoint."""
        self._next, self._names = state[0], dict(state[1])

    def _new(self, used: Collection[str]) -> str:
        """Return the next Torso ID that is free; with all in use, a further one."""
        turn = (number % MOST + 1 for number in range(self._next - 1, self._next - 1 + MOST))
        number = next(number for number in (*turn, *range(MOST + 1, MOST + len(used) + 2)) if _name(number) not in used)
        self._next = number % MOST + 1
        return _name(number)


def _name(number: int) -> str:
    return f"torso_{number}"
