"""Detections from the truth, with noise, in place of a detector: they tell its errors from those of the rest."""

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_msgs import PositionMeasurement, PositionMeasurementArray
from robots.demo.people_score import HALF

Floats = NDArray[np.float64]

NAME = "truth"
"""Name of the detector in its measurements."""

BASE_LINK = "base_link"
MISSED = 0.02
"""Share of detections that are missed."""
SIGMA, SIGMA_DEPTH = 0.03, 1.425e-3
"""Standard deviation of a position [m], and its growth with the square of the distance [1/m], as of a Kinect."""
TORSO_HEIGHT = 1.2
"""Height of the measured points [m]."""


def measurements(
    stamp: float, robot: Pose2D, people: Floats, shares: Floats, rng: np.random.Generator
) -> PositionMeasurementArray:
    """Return measurements of the people that a robot has in view, in its base frame.

    Parameters
    ----------
    stamp : float
        [s since the epoch].
    robot : Pose2D
        True pose of the robot.
    people : (n, 2) array
        True positions of all people [m].
    shares : (n,) array
        Share of each torso that the robot has in view.
    rng : numpy.random.Generator
        Random source of the noise and of the missed people.
    """
    header = Header(stamp=Time.of(stamp), frame_id=BASE_LINK)
    seen = np.flatnonzero((shares >= HALF) & (rng.random(len(people)) >= MISSED))
    return PositionMeasurementArray(header, [_measurement(header, robot, people[each], rng) for each in seen])


def _measurement(header: Header, robot: Pose2D, person: Floats, rng: np.random.Generator) -> PositionMeasurement:
    x, y, _ = robot.inverse() @ Pose2D(*person.tolist())
    sigma = SIGMA + SIGMA_DEPTH * (x * x + y * y)
    x, y = (rng.normal((x, y), sigma)).tolist()
    variance = sigma * sigma
    covariance = [variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance]
    return PositionMeasurement(header, NAME, "", Point(x, y, TORSO_HEIGHT), 0.9, covariance)
