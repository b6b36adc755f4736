"""Reports of robots, checked and as arrays."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.people_coordination import PeopleReport, SensorView
from ppaas.messages.people_msgs import PositionMeasurement
from ppaas.people.coordinator.positions import position_deviation
from ppaas.people.state_checks import check_view

Array = NDArray[np.float64]

MOST_PEOPLE, MOST_VIEWS = 200, 16
PLANAR = 0, 1, 5
"""Rows of x, y and yaw in the covariance of a pose."""
FARTHEST = 100.0
"""Largest distance between a robot and a person whom it sees [m]."""
UNKNOWN_VARIANCE = 0.15**2
"""Variance of a torso whose covariance is all zeros, which is "unknown" in ROS [m²]."""
LEAST_VARIANCE = 0.02**2
MOST_VARIANCE = 4.0
MOST_OF_POSE = 100.0**2
"""Largest variance of a pose [m², rad²]: some robots write very large ones for what they do not know."""
ONE_PERSON = 0.35
"""Distance within which two people cannot stand, so that two torsos of a robot are one person [m]."""
OUTERMOST = 1e5
"""Largest coordinate of a robot [m]."""


@dataclass(frozen=True, slots=True)
class Report:
    """A report of a robot.

    Parameters
    ----------
    robot : str
        Robot ID.
    stamp : float
        Time of the measurements by the robot's clock [s].
    pose : Pose2D
        Pose of the robot in the map.
    pose_covariance : (3, 3) array
        Covariance of x, y and yaw.
    deviation : float
        Distance within which the robot is at its position with 95 % certainty [m].
    ids, frames : list of str
        Torso ID and tf frame of each person.
    torsos : (n, 2) array
        Positions in the robot's frame [m].
    covariances : (n, 2, 2) array
        [m²].
    scores : (n,) array
        Reliability of each, from 0 to 1.
    views : list of SensorView
    can_follow : bool
    following : int
    outside : int
        Number of its people who were left out, because nobody can be where they appear.
    """

    robot: str
    stamp: float
    pose: Pose2D
    pose_covariance: Array
    deviation: float
    ids: list[str]
    frames: list[str]
    torsos: Array
    covariances: Array
    scores: Array
    views: list[SensorView]
    can_follow: bool
    following: int
    outside: int = 0

    def without(self, left_out: NDArray[np.bool_], outside: int = 0) -> "Report":
        """Return the report without some of its people, by an (n,) mask, of whom a number is outside the map."""
        if not left_out.any():
            return self
        kept = ~left_out
        numbers = np.flatnonzero(kept).tolist()
        return replace(
            self,
            ids=[self.ids[number] for number in numbers],
            frames=[self.frames[number] for number in numbers],
            torsos=self.torsos[kept],
            covariances=self.covariances[kept],
            scores=self.scores[kept],
            outside=self.outside + outside,
        )


def read_report(message: PeopleReport) -> Report:
    """Return a report as arrays.

    Raises
    ------
    InvalidInput
        A number is not finite or out of range, two torsos have the same id, or there are too many.
    """
    who = f"report of robot {message.robot!r}"
    if not message.robot:
        raise InvalidInput("a report must name its robot")
    pose = message.pose.pose.planar()
    covariance = message.pose.covariance
    if not (pose.is_finite() and len(covariance) == 36 and all(map(math.isfinite, covariance))):
        raise InvalidInput(f"{who}: its pose and covariance must be finite")
    if max(abs(pose.x), abs(pose.y)) > OUTERMOST:
        raise InvalidInput(f"{who}: its position must be within {OUTERMOST:g} m")
    if min(covariance[0], covariance[7], covariance[35]) < 0.0:
        raise InvalidInput(f"{who}: the variances of its pose must not be negative")
    planar = _planar(covariance)
    _check_people(who, message.people)
    _check_views(who, message.views)
    torsos = np.array([(each.pos.x, each.pos.y) for each in message.people], np.float64).reshape(-1, 2)
    return Report(
        robot=message.robot,
        stamp=message.header.stamp.seconds(),
        pose=pose,
        pose_covariance=planar,
        deviation=position_deviation(planar),
        ids=[each.object_id for each in message.people],
        frames=[each.name or f"{message.robot}/{each.object_id}" for each in message.people],
        torsos=torsos,
        covariances=_covariances(message.people),
        scores=np.array([min(max(each.reliability, 0.0), 1.0) for each in message.people], np.float64),
        views=list(message.views),
        can_follow=message.can_follow,
        following=message.following,
    )


def detected_twice(report: Report, bound: Mapping[str, int]) -> NDArray[np.bool_]:
    """Return which torsos, as an (n,) mask, are a person who has another torso in the same report.

    Parameters
    ----------
    report : Report
    bound : mapping of str to int
        Id of the person that each torso was before: the torso of the person who is known for longer is kept, or else
        the one with the better score.
    """
    left_out = np.zeros(len(report.ids), np.bool_)
    off = report.torsos[:, np.newaxis] - report.torsos
    near = off[..., 0] ** 2 + off[..., 1] ** 2 < ONE_PERSON**2
    if near.sum() == len(near):
        return left_out
    for one, other in np.argwhere(np.triu(near, 1)).tolist():
        if not left_out[one] and not left_out[other]:
            last = max(one, other, key=lambda row: (bound.get(report.ids[row], math.inf), -report.scores[row]))
            left_out[last] = True
    return left_out


def _check_people(who: str, people: list[PositionMeasurement]) -> None:
    if len(people) > MOST_PEOPLE:
        raise InvalidInput(f"{who}: it may have up to {MOST_PEOPLE} people, not {len(people)}")
    if len({each.object_id for each in people}) != len(people):
        raise InvalidInput(f"{who}: its people must have different ids")
    for each in people:
        numbers = (each.pos.x, each.pos.y, each.reliability, *each.covariance)
        if not all(map(math.isfinite, numbers)):
            raise InvalidInput(f"{who}: the numbers of person {each.object_id!r} must be finite")
        if math.hypot(each.pos.x, each.pos.y) > FARTHEST:
            raise InvalidInput(f"{who}: person {each.object_id!r} must be within {FARTHEST:g} m")
        if len(each.covariance) != 9 or each.covariance[0] < 0.0 or each.covariance[4] < 0.0:
            raise InvalidInput(f"{who}: the covariance of person {each.object_id!r} must be 3 × 3 and not negative")


def _check_views(who: str, views: list[SensorView]) -> None:
    if len(views) > MOST_VIEWS:
        raise InvalidInput(f"{who}: it may have up to {MOST_VIEWS} views, not {len(views)}")
    for view in views:
        check_view(view, f"{who}: a view")


def _planar(covariance: Sequence[float]) -> Array:
    """Return the (3, 3) covariance of x, y and yaw; without correlations if they are stronger than any can be."""
    limited = np.clip(np.reshape(covariance, (6, 6))[np.ix_(PLANAR, PLANAR)], -MOST_OF_POSE, MOST_OF_POSE)
    planar: Array = 0.5 * (limited + limited.T)
    (xx, xy, xt), (_, yy, yt), (_, _, tt) = planar.tolist()
    minors = xx * yy - xy * xy, xx * tt - xt * xt, yy * tt - yt * yt
    whole = xx * minors[2] - xy * (xy * tt - yt * xt) + xt * (xy * yt - yy * xt)
    possible = min(*minors, whole) >= 0.0
    return planar if possible else np.diag(np.diag(planar))


def _covariances(people: list[PositionMeasurement]) -> Array:
    """Return the (n, 2, 2) covariances of x and y, symmetric, and neither implausibly small nor large."""
    rows = np.array([each.covariance for each in people], np.float64).reshape(-1, 3, 3)[:, :2, :2]
    unknown = (rows[:, 0, 0] == 0.0) & (rows[:, 1, 1] == 0.0)
    rows[unknown] = UNKNOWN_VARIANCE * np.eye(2)
    xx = np.clip(rows[:, 0, 0], LEAST_VARIANCE, MOST_VARIANCE)
    yy = np.clip(rows[:, 1, 1], LEAST_VARIANCE, MOST_VARIANCE)
    most = 0.95 * np.sqrt(xx * yy)
    xy = np.clip(0.5 * rows[:, 0, 1] + 0.5 * rows[:, 1, 0], -most, most)
    spread = np.empty_like(rows)
    spread[:, 0, 0], spread[:, 1, 1] = xx, yy
    spread[:, 0, 1] = spread[:, 1, 0] = xy
    return spread
