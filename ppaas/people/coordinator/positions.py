"""Positions of robots and people in the world frame: deviations, and offsets from people whom others see, too."""

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.people.tracks.filter_bank import squared_distances

# -- step 1: maximum position deviation of each robot ------------------------------------------------------------------

CONFIDENCE = math.sqrt(5.991)
"""Standard deviations that hold 95 % of a Gaussian in the plane (χ² of two degrees of freedom)."""
UNKNOWN = 0.5
"""Deviation of a robot whose covariance is all zeros, which is "unknown" in ROS [m]."""
LEAST = 0.05
"""Least deviation: the width of a cell of usual maps [m]."""


def position_deviation(covariance: NDArray[np.float64]) -> float:
    """Return the distance within which a robot is at its position with 95 % certainty [m].

    Parameters
    ----------
    covariance : (3, 3) array
        Covariance of x, y [m²] and yaw [rad²], of AMCL for example.
    """
    (xx, xy, _), (_, yy, _), _ = covariance.tolist()
    return UNKNOWN if xx == yy == 0.0 else max(radius_of(xx, xy, yy), LEAST)


def radius_of(xx: float, xy: float, yy: float) -> float:
    """Return the radius [m] that holds 95 % of a Gaussian along its widest axis, from its covariance [m²]."""
    widest = 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy)
    return CONFIDENCE * math.sqrt(max(widest, 0.0))


def maximum_position_deviation(history: Iterable[float], disagreement: float = 0.0) -> float:
    """Return the maximum position deviation of a robot [m].

    The paper: "maximum position deviation of each robot", from the covariance of AMCL and its history.

    Parameters
    ----------
    history : iterable of float
        Its deviations of the last seconds: the certainty that a filter just regained may be a wrong one [m].
    disagreement : float
        Distance between where it sees people and where other robots see the same people [m].
    """
    return max(max(history, default=UNKNOWN), disagreement)


Array = NDArray[np.float64]


# -- step 2: torso coordinates in the world frame ----------------------------------------------------------------------


def to_world(pose: Pose2D, pose_covariance: Array, torsos: Array, covariances: Array) -> tuple[Array, Array]:
    """Return torsos in the frame of the map, with the uncertainty of the robot's own pose.

    The paper: "all torso coordinates to the world frame".

    Parameters
    ----------
    pose : Pose2D
        Pose of the robot in the map.
    pose_covariance : (3, 3) array
        Covariance of x, y [m²] and yaw [rad²] in the frame of the map.
    torsos : (n, 2) array
        Positions in the frame of the robot [m].
    covariances : (n, 2, 2) array
        Their covariances in that frame [m²].

    Returns
    -------
    positions : (n, 2) array
    covariances : (n, 2, 2) array
        To first order: turned into the map, plus the covariances of the position and of the yaw times the lever.
    """
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    turn = np.array([[c, -s], [s, c]])
    lever = torsos @ turn.T
    jacobian = jacobian_of(lever)
    spread = turn @ covariances @ turn.T + jacobian @ pose_covariance @ np.swapaxes(jacobian, 1, 2)
    return lever + np.array([pose.x, pose.y]), spread


def jacobian_of(levers: Array) -> Array:
    """Return the (n, 2, 3) derivatives of positions at (n, 2) levers [m] by the x, y and yaw of the robot."""
    jacobian = np.zeros((len(levers), 2, 3))
    jacobian[:, 0, 0] = jacobian[:, 1, 1] = 1.0
    jacobian[:, 0, 2], jacobian[:, 1, 2] = -levers[:, 1], levers[:, 0]
    return jacobian


# -- offset of a robot -------------------------------------------------------------------------------------------------

FORGET = 30.0
"""Time constant with which an offset that nothing confirms returns to zero [s]."""
GATE = 13.8
"""Squared Mahalanobis distance beyond which a residual is not of the same person."""
ACROSS = 0.1
"""Standard deviation of the difference between the centres of a person whom two robots see from two sides [m]."""
REPEATED = 5.0
"""Successive observations that count as much as one: the errors of people who stand, or are confused, stay the same."""
MOST_YAW = 0.3
"""Limit of the yaw of an offset [rad]."""


class OffsetFilter:
    """Kalman filter of the error x, y, yaw of the pose of a robot.

    Attributes
    ----------
    mean : (3,) array
        Where the robot believes to be, minus where it is [m, m, rad].
    covariance : (3, 3) array
    at : float
        Time of the last prediction [s].
    """

    def __init__(self, now: float = 0.0) -> None:
        self.at = now
        self.mean: Array = np.zeros(3)
        self.covariance: Array = np.zeros((3, 3))

    def predict(self, now: float, prior: Array) -> None:
        """Apply the offset's drift until a time [s], towards the (3, 3) covariance of the robot's own localization."""
        seconds, self.at = max(now - self.at, 0.0), now
        fading = float(np.exp(-seconds / FORGET))
        self.mean = fading * self.mean
        self.covariance = fading**2 * self.covariance + (1.0 - fading**2) * prior

    def observe(self, levers: Array, residuals: Array, covariances: Array) -> None:
        """Update the offset by people whom other robots see as well.

        Parameters
        ----------
        levers : (n, 2) array
            From the robot's position to each person, in the frame of the map [m].
        residuals : (n, 2) array
            Where this robot sees each person, minus where the others do [m].
        covariances : (n, 2, 2) array
            Their covariances [m²], without the offset's.
        """
        model = jacobian_of(levers)
        covariances = REPEATED * (covariances + ACROSS**2 * np.eye(2))
        total = model @ self.covariance @ np.swapaxes(model, 1, 2) + covariances
        near = squared_distances(residuals - model @ self.mean, total) < GATE
        levers, residuals, covariances = levers[near], residuals[near], covariances[near]
        count = len(levers)
        model = model[near].reshape(2 * count, 3)
        noise = np.zeros((2 * count, 2 * count))
        for k, covariance in enumerate(covariances):
            noise[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = covariance
        total = model @ self.covariance @ model.T + noise
        gain = np.linalg.solve(total, model @ self.covariance).T
        self.mean = self.mean + gain @ (residuals.reshape(-1) - model @ self.mean)
        self.mean[2] = np.clip(self.mean[2], -MOST_YAW, MOST_YAW)
        corrected = self.covariance - gain @ model @ self.covariance
        self.covariance = 0.5 * (corrected + corrected.T)

    def doubt(self, distance: float) -> None:
        """Widen the covariance after a contradiction by a distance [m], so that the next observations correct it."""
        self.covariance = self.covariance + np.diag([distance**2, distance**2, 0.02**2])

    def corrected(self, positions: Array, origin: tuple[float, float]) -> Array:
        """Return (n, 2) positions [m] without the offset, seen from a robot at ``origin``."""
        return without_offset(positions, np.array(origin), self.mean)

    @property
    def error(self) -> float:
        """Largest distance between where the robot believes to be and where it is, with 95 % certainty [m].

        It is 0 before other robots have seen the same people: then only the robot itself knows how sure it is.
        """
        x, y, _ = self.mean.tolist()
        if x == y == 0.0:
            return 0.0
        return math.hypot(x, y) + self.radius

    @property
    def radius(self) -> float:
        """Distance within which the robot is where its offset says, with 95 % certainty [m]."""
        (xx, xy, _), (_, yy, _), _ = self.covariance.tolist()
        return radius_of(xx, xy, yy)


def without_offset(positions: Array, origins: Array, offsets: Array) -> Array:
    """Return (n, 2) positions [m] without offsets, (n, 3) or one, seen from robots at origins, (n, 2) or one [m]."""
    x, y, yaw = offsets[..., 0], offsets[..., 1], offsets[..., 2]
    levers = positions - origins
    return positions - np.stack((x - yaw * levers[:, 1], y + yaw * levers[:, 0]), axis=-1)
