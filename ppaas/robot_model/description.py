"""Description of a robot that results from its URDF."""

import math
from dataclasses import dataclass

from ppaas.transforms.spatial import Rigid

Corner = tuple[float, float]

_ROUNDING = 1000.0
"""Steps per metre of rounded radii: robots whose radii differ by less than 1 mm share the layers of a map [1/m]."""


@dataclass(frozen=True, slots=True)
class SensorFrame:
    """Link that is a sensor.

    Parameters
    ----------
    link : str
        Name of the link, which is the sensor's frame.
    kind : str
        ``laser``, ``camera``, ``depth``, or the type in the URDF.
    pose : tuple of float
        x, y, z [m], roll, pitch, yaw [rad] in the base frame.
    """

    link: str
    kind: str
    pose: tuple[float, float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class RobotDescription:
    """Body of a robot with all joints at zero.

    Parameters
    ----------
    name : str
        Name of the robot in the URDF.
    base_frame : str
        ``base_footprint``, ``base_link`` or the root link: the frame of all poses and of the footprint.
    links : int
        Number of links.
    footprint : tuple of (x, y)
        Corners of the convex hull seen from above, counter-clockwise [m]; empty if unknown.
    height : float, optional
        Height from the ground to the top [m].
    max_vel_x, max_vel_theta : float, optional
        Limits by the speeds of the wheels [m/s, rad/s].
    sensors : tuple of SensorFrame
        Sensors of the robot.
    warnings : tuple of str
        Properties that could not be determined, and why; the most important first.
    frames : tuple of (str, Rigid)
        Links that do not move, and sensors, with their poses in the base frame.
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
    frames: tuple[tuple[str, Rigid], ...] = ()

    @property
    def circumscribed_radius(self) -> float | None:
        """Radius of the smallest disc around the base frame that contains the footprint, rounded up to 1 mm [m]."""
        return circumscribed_radius(self.footprint) if self.footprint else None

    @property
    def inscribed_radius(self) -> float | None:
        """Radius of the largest disc around the base frame within the footprint; 0 if the frame is outside [m]."""
        return inscribed_radius(self.footprint) if self.footprint else None


def circumscribed_radius(footprint: tuple[Corner, ...]) -> float:
    """Return the radius of the smallest disc around (0, 0) that contains a footprint, rounded up to 1 mm [m]."""
    reach = max(math.hypot(*corner) for corner in footprint)
    return math.ceil(reach * _ROUNDING - 1e-6) / _ROUNDING


def inscribed_radius(footprint: tuple[Corner, ...]) -> float:
    """Return the radius of the largest disc around (0, 0) within a convex, counter-clockwise footprint [m].

    It is 0 if (0, 0) is outside the footprint.
    """
    radius = math.inf
    for (ax, ay), (bx, by) in zip(footprint, (*footprint[1:], footprint[0]), strict=True):
        edge = math.hypot(bx - ax, by - ay)
        radius = min(radius, (ax * by - bx * ay) / edge if edge else 0.0)
    return max(0.0, radius)
