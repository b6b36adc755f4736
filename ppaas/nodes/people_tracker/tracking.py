"""Tracking of readings: converts them into the frame of the odometry, and feeds the tracker."""

import math

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.people_coordination import SensorView
from ppaas.nodes.people_tracker.poses import RobotPoses
from ppaas.nodes.people_tracker.readings import FramedPerson, Reading
from ppaas.nodes.topics import DETECTIONS, PEOPLE, TF
from ppaas.people.clock_offsets import LATEST, TOLERANCE, ClockOffset, corrected
from ppaas.people.state_checks import check_view
from ppaas.people.tracks.robot_tracker import HELD, RobotTracker, RobotTrackerState
from ppaas.people.tracks.tracker import Detection, LocalTrack

IN_USE = HELD
"""Time after its last measurement for which a detector counts as in use [s]: that for which its people count as seen.

A view without its people would mean that they have left.
"""

FASTEST_ROBOT = 5.0
"""Speed above which the odometry was reset [m/s]."""

_ODOMETRY = "odometry"


class DeviceClocks:
    """Offsets of the clocks of a robot's devices: stamps of detections by the clock of the odometry, or here."""

    def __init__(self) -> None:
        self._offsets: dict[str, ClockOffset] = {_ODOMETRY: ClockOffset()}

    def note_odometry(self, stamp: float, now: float) -> None:
        """Note the stamp of odometry that arrives at ``now`` [s]."""
        self._offsets[_ODOMETRY].note(stamp, now)

    def in_odometry(self, source: str, stamp: float, now: float, newest: float | None) -> float:
        """Return the stamp of a detection that arrives now by the clock of the odometry [s].

        Parameters
        ----------
        source : str
            Topic of the detection.
        stamp : float
            By the clock of its device [s]; 0 for the time of the newest odometry, and unchanged.
        now : float
            Time of stamps [s].
        newest : float or None
            Stamp of the newest odometry [s]; without odometry the stamp is unchanged.

        Raises
        ------
        InvalidInput
            It is out of date: later by `LATEST` than the others of this topic.
        """
        if not stamp or newest is None:
            return stamp
        offset = self._offsets.setdefault(source, ClockOffset())
        delay = offset.note(stamp, now)
        if delay > LATEST:
            raise InvalidInput(
                f"detections on {source!r} are stamped {delay:.1f} s earlier than the others before them: they are out "
                "of date, send each once, as soon as it is made"
            )
        apart = offset.seconds - self._offsets[_ODOMETRY].seconds
        return stamp + apart if abs(apart) > TOLERANCE else stamp

    def here(self, stamp: float) -> float:
        """Return a time of the odometry by the clock of this computer [s]."""
        return corrected(stamp, self._offsets[_ODOMETRY].seconds)


class TrackingState(msgspec.Struct):
    """Checkpoint of `ReadingTracker`."""

    tracker: RobotTrackerState
    views: dict[str, SensorView]


class ReadingTracker:
    """Tracks the people of readings.

    Parameters
    ----------
    poses : RobotPoses
    own_view : SensorView or None
        Where the robot sees the people that it sends itself; None if it does not say.

    Attributes
    ----------
    clocks : DeviceClocks
        Clocks of the devices.
    """

    def __init__(self, poses: RobotPoses, own_view: SensorView | None) -> None:
        self.clocks = DeviceClocks()
        self._poses = poses
        self._tracker = RobotTracker()
        self._views = {} if own_view is None else {PEOPLE.name: own_view, DETECTIONS.name: own_view}
        self._measured: dict[str, float] = {}
        self._before: tuple[str, float, Pose2D] | None = None

    @property
    def at(self) -> float:
        """Time of the people [s]; infinitely early before the first reading."""
        return self._tracker.at

    def use_view(self, source: str, view: SensorView) -> None:
        """Use where a detector sees people; ``InvalidInput`` if a number is not plausible."""
        check_view(view, f"the view of the detector of {source!r}")
        self._views[source] = view

    def views(self, at: float) -> list[SensorView]:
        """Return the views of the detectors in use at a time [s], each once."""
        used = [
            view for source, view in self._views.items() if abs(at - self._measured.get(source, -math.inf)) <= IN_USE
        ]
        return [view for k, view in enumerate(used) if view not in used[:k]]

    def use(self, reading: Reading, stamp: float) -> None:
        """Update the tracks by a reading, at its time [s].

        Raises
        ------
        TransformError
            Its frame is unknown, or the pose of the robot at that time.
        """
        robot = self._poses.robot(stamp)
        to_base = self._poses.to_base(reading.frame, stamp)
        self._restart_after_jump(robot, stamp)
        turned = _matrix(robot) @ to_base
        found = [_found(person, turned, to_base) for person in reading.people]
        self._tracker.step(reading.source, stamp, found, self._views.get(reading.source), robot)
        self._measured[reading.source] = stamp

    def predict(self) -> None:
        """Predict the people until the newest pose of the robot."""
        newest = self._poses.newest()
        if newest is not None:
            self._tracker.predict(newest)

    def seen(self) -> list[LocalTrack]:
        """Return the people whom the robot sees, in the frame in which they are tracked."""
        return self._tracker.seen()

    def tracks(self) -> set[int]:
        """Return the ids of all tracks, also of people who are hidden now."""
        return self._tracker.tracks()

    def own_id(self, track: int) -> str:
        """Return the Torso ID that the robot itself publishes for a track; empty for none."""
        return self._tracker.name_by(TF.name, track)

    def _restart_after_jump(self, robot: Pose2D, stamp: float) -> None:
        """Forget all people if their frame is another, or the odometry was reset."""
        frame, before = self._poses.frame, self._before
        if before is not None:
            far = before[2].distance_to(robot) > FASTEST_ROBOT * abs(stamp - before[1]) + 0.1
            if before[0] != frame or (far and abs(stamp - before[1]) < 1.0):
                self._tracker.restart()
        self._before = frame, stamp, robot

    def state(self) -> TrackingState:
        """Return a checkpoint."""
        return TrackingState(self._tracker.state(), self._views)

    def restore(self, state: TrackingState) -> None:
        """Go on from a checkpoint."""
        self._tracker.restore(state.tracker)
        self._views |= state.views


def _matrix(pose: Pose2D) -> NDArray[np.float64]:
    """Return the (4, 4) matrix of a pose in the plane."""
    matrix = np.eye(4)
    cos, sin = math.cos(pose.theta), math.sin(pose.theta)
    matrix[:2, :2] = (cos, -sin), (sin, cos)
    matrix[:2, 3] = pose.x, pose.y
    return matrix


def _found(person: FramedPerson, matrix: NDArray[np.float64], to_base: NDArray[np.float64]) -> Detection:
    """Return a person in the frame in which people are tracked; ``z`` is the height in the robot's frame."""
    place = np.array((*person.position, 1.0))
    x, y = (matrix @ place)[:2].tolist()
    turn = matrix[:2, :3]
    (xx, xy), (_, yy) = (turn @ np.array(person.covariance).reshape(3, 3) @ turn.T).tolist()
    z = float((to_base @ place)[2])
    return Detection(x, y, (xx, xy, yy), person.score, person.begins, z=z, id=person.id)
