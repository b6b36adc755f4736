"""Reports of a people tracker: whom the robot sees, from where, and what it does."""

import math
from typing import NamedTuple

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point, TransformStamped
from ppaas.messages.people_coordination import FollowStatus, PeopleReport
from ppaas.messages.people_msgs import PositionMeasurement, PositionMeasurementArray
from ppaas.nodes.frames import MAP
from ppaas.nodes.people_tracker.person_frames import PersonFrames
from ppaas.nodes.people_tracker.poses import RobotPoses
from ppaas.nodes.people_tracker.tracking import ReadingTracker
from ppaas.people.robot_tracks.robot_tracker import SeenPerson

HEIGHT_VARIANCE = 0.04
"""Variance of the height of a person's position [m²]."""


class Follower(NamedTuple):
    """What a robot does to follow a person, for its reports: see `PeopleReport`."""

    can_follow: bool = False
    following: int = 0
    gave_up: int = 0

    @classmethod
    def of(cls, status: FollowStatus) -> "Follower":
        """Return it from the status of the robot's follower."""
        return cls(status.can_follow, status.following, status.gave_up)


class SeenPeople(NamedTuple):
    """The people that a robot sees at a time.

    Parameters
    ----------
    stamp : float
        Time by the clock of the odometry [s].
    measurements : PositionMeasurementArray
        In the robot's frame.
    frames : list of TransformStamped
        Frames of those that the robot does not publish itself.
    """

    stamp: float
    measurements: PositionMeasurementArray
    frames: list[TransformStamped]


class Reporter:
    """Makes the messages of a people tracker.

    Parameters
    ----------
    robot : str
        Robot ID.
    poses : RobotPoses
    tracking : ReadingTracker
    frames : PersonFrames
    """

    def __init__(self, robot: str, poses: RobotPoses, tracking: ReadingTracker, frames: PersonFrames) -> None:
        self._robot, self._poses = robot, poses
        self._tracking, self._frames = tracking, frames

    def people(self, base: str, now: float) -> SeenPeople:
        """Return the people that the robot sees at the time of the last measurement.

        Parameters
        ----------
        base : str
            Frame of the robot's body.
        now : float
            Time by the executor's clock [s].

        Raises
        ------
        TransformError
            The pose of the robot at that time is unknown.
        """
        stamp = self._stamp()
        inverse = self._poses.robot(stamp).inverse()
        header = Header(stamp=Time.of(stamp), frame_id=base)
        seen = self._tracking.seen()
        self._frames.ids.keep(self._tracking.tracks())
        taken = self._frames.taken(now)
        people = []
        for each in seen:
            name = self._frames.ids.of(each.id, self._tracking.own_id(each.id), taken)
            people.append(_measurement(header, self._frames.frame(name), name, each, inverse))
        return SeenPeople(stamp, PositionMeasurementArray(header, people), self._frames.transforms(people, now))

    def _stamp(self) -> float:
        """Return the time of the people: of the last measurement, or of the newest pose before the first."""
        newest = self._poses.newest()
        assert newest is not None
        return self._tracking.at if math.isfinite(self._tracking.at) else newest

    def report(self, seen: SeenPeople, follower: Follower, now: float) -> PeopleReport:
        """Return the report to the coordinator.

        Raises
        ------
        TransformError
            The robot is not localized.
        """
        pose = self._poses.in_map(seen.stamp, now)
        header = Header(stamp=Time.of(self._tracking.clocks.here(seen.stamp)), frame_id=MAP)
        return PeopleReport(
            header, self._robot, pose, seen.measurements.people, self._tracking.views(seen.stamp), *follower
        )


def _measurement(header: Header, frame: str, name: str, seen: SeenPerson, to_base: Pose2D) -> PositionMeasurement:
    place = to_base @ Pose2D(seen.x, seen.y)
    cos, sin = math.cos(to_base.theta), math.sin(to_base.theta)
    turn = np.array(((cos, -sin), (sin, cos)))
    xx, xy, yy = seen.covariance
    (a, b), (_, d) = (turn @ np.array(((xx, xy), (xy, yy))) @ turn.T).tolist()
    covariance = [a, b, 0.0, b, d, 0.0, 0.0, 0.0, HEIGHT_VARIANCE]
    return PositionMeasurement(header, frame, name, Point(place.x, place.y, seen.z), seen.score, covariance, 1)
