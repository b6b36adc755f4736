"""What is told of a robot by its URDF, once it is read."""

import math
from dataclasses import dataclass

Corner = tuple[float, float]

_ROUNDING = 1000.0
"""Radii are whole millimetres: robots that differ by less share the layers of a map."""


@dataclass(frozen=True, slots=True)
class SensorFrame:
    """A link that is a sensor.

    Parameters
    ----------
    link : str
        Its frame.
    kind : str
        ``laser``, ``camera``, ``depth``, or what the URDF calls it.
    pose : tuple of float
        x, y, z [m], roll, pitch, yaw [rad] in the base frame.
    """

    link: str
    kind: str
    pose: tuple[float, float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class RobotDescription:
    """The body of a robot, all its joints at zero.

    Parameters
    ----------
    name : str
        Of the robot, as the URDF says.
    base_frame : str
        ``base_footprint``, ``base_link`` or the root: the frame of all that follows.
    links : int
        How many it has.
    footprint : tuple of (x, y)
        Corners of the convex outline seen from above, counter-clockwise [m]; none where it cannot be told.
    height : float, optional
        From the ground to the top [m].
    max_vel_x, max_vel_theta : float, optional
        What its wheels allow [m/s, rad/s].
    sensors : tuple of SensorFrame
    warnings : tuple of str
        What could not be told, and why.
    """

    name: str
    base_frame: str
    links: int
    footprint: tuple[Corner, ...] = ()
    height: float | None = None
    max_vel_x: float | None = None
    max_vel_theta: float | None = None
    sensors: tuple[SensorFrame, ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    def circumscribed_radius(self) -> float | None:
        """Of the disc around the base frame that holds the robot however it turns, in whole millimetres [m]."""
        return circumscribed_radius(self.footprint) if self.footprint else None

    @property
    def inscribed_radius(self) -> float | None:
        """Of the largest disc around the base frame that lies in the footprint, 0 if it is not in it [m]."""
        return inscribed_radius(self.footprint) if self.footprint else None


def circumscribed_radius(footprint: tuple[Corner, ...]) -> float:
    """Return the radius of the disc around 0, 0 that holds a footprint, in whole millimetres [m]."""
    reach = max(math.hypot(*corner) for corner in footprint)
    return math.ceil(reach * _ROUNDING - 1e-6) / _ROUNDING


def inscribed_radius(footprint: tuple[Corner, ...]) -> float:
    """Return the radius of the largest disc around 0, 0 in a convex, counter-clockwise footprint; 0 if none is [m]."""
    radius = math.inf
    for (ax, ay), (bx, by) in zip(footprint, (*footprint[1:], footprint[0]), strict=True):
        edge = math.hypot(bx - ax, by - ay)
        radius = min(radius, (ax * by - bx * ay) / edge if edge else 0.0)
    return max(0.0, radius)
