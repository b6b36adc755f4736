"""Tracker of the people that one robot sees, by all of its detectors, in a frame that does not move with it."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import msgspec

from ppaas.geometry import Pose2D
from ppaas.messages.people_coordination import SensorView
from ppaas.people.robot_tracks.views import hides, sees
from ppaas.people.tracks.tracker import Detection, LocalTrack, Tracker, TrackerState

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


class Found(NamedTuple):
    """A person in a measurement, in the frame in which people are tracked.

    Parameters
    ----------
    x, y, z : float
        Position; z is the height above the floor, 0 if it is unknown [m].
    covariance : (xx, xy, yy)
        Covariance of the position [m²].
    score : float
        From 0 to 1.
    begins : bool
        Whether it may begin a track.
    id : str
        Id that the detector keeps for the person; empty if it tracks nobody.
    """

    x: float
    y: float
    z: float
    covariance: tuple[float, float, float]
    score: float
    begins: bool
    id: str = ""


class SeenPerson(NamedTuple):
    """A person whom the robot sees, at the time of the last step.

    Parameters
    ----------
    id : int
        Id of the track, from 1; it is not reused.
    x, y, z : float
        Position [m].
    covariance : (xx, xy, yy)
        Covariance of the position [m²].
    score : float
    """

    id: int
    x: float
    y: float
    z: float
    covariance: tuple[float, float, float]
    score: float


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
        self._tracker = Tracker()
        self._newest: dict[int, tuple[float, Found]] = {}
        self._seen_by: dict[int, dict[str, float]] = {}
        self._believed: dict[tuple[str, str], int] = {}

    @property
    def at(self) -> float:
        """Time of the last step [s]."""
        return self._tracker.at

    def step(self, source: str, now: float, found: Sequence[Found], view: SensorView | None, robot: Pose2D) -> None:
        """Update the tracks by a measurement.

        Parameters
        ----------
        source : str
            Name of the detector.
        now : float
            Time of the measurement [s].
        found : sequence of Found
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
        detections = [
            Detection(each.x, each.y, each.covariance, each.score, each.begins, self._believed_id(source, each.id))
            for each in found
        ]

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

    def seen(self) -> list[SeenPerson]:
        """Return the people whom the robot sees now."""
        people = []
        for track in self._tracker.people:
            if self.at - track.last_seen > HELD or track.id not in self._newest:
                continue
            measured_at, newest = self._newest[track.id]
            here = measured_at >= self.at
            x, y = (newest.x, newest.y) if here else (track.x, track.y)
            covariance = newest.covariance if here else track.covariance
            people.append(SeenPerson(track.id, x, y, newest.z, covariance, track.score))
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
            track.id: (track.last_seen, Found(track.x, track.y, 0.0, track.covariance, track.score, True))
            for track in self._tracker.tracks
        }

    def _moved_on(self, found: Found, late: float) -> Found:
        """Return a late detection where the person is now, by the velocity of the nearest track."""
        if late <= 0.0 or not self._tracker.tracks:
            return found
        nearest = min(self._tracker.tracks, key=lambda track: math.hypot(track.x - found.x, track.y - found.y))
        if math.hypot(nearest.x - found.x, nearest.y - found.y) > LATE:
            return found
        return found._replace(x=found.x + nearest.vx * late, y=found.y + nearest.vy * late)

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

    def _note(self, track: int, source: str, found: Found) -> None:
        self._newest[track] = self.at, found if found.z else found._replace(z=self._height(track))
        self._seen_by.setdefault(track, {})[source] = self.at
        if found.id:
            self._believed.pop((source, found.id), None)
            self._believed[source, found.id] = track
            if len(self._believed) > MOST_IDS:
                self._believed.pop(next(iter(self._believed)))

    def _height(self, track: int) -> float:
        """Return the last known height of a person: lasers do not measure it."""
        return self._newest[track][1].z if track in self._newest else 0.0

    def _forget(self) -> None:
        kept = {track.id for track in self._tracker.tracks}
        self._newest = {track: newest for track, newest in self._newest.items() if track in kept}
        self._seen_by = {track: seen for track, seen in self._seen_by.items() if track in kept}
        self._believed = {key: track for key, track in self._believed.items() if track in kept}
