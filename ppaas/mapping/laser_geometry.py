"""Geometry of a laser: the directions of its beams and its pose on the robot."""

import math
from dataclasses import dataclass

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D

MAX_BEAMS = 10_000


@dataclass(frozen=True, slots=True)
class LaserGeometry:
    """Directions of the beams of a laser, and its place on the robot.

    Parameters
    ----------
    angle_min : float
        Direction of beam 0 relative to the laser's heading [rad].
    angle_increment : float
        Angle from each beam to the next [rad]; negative if the laser turns clockwise.
    beams : int
        Number of ranges of each scan.
    mount : Pose2D
        Pose of the laser in the frame of the robot, to which the odometry refers.
    time_increment : float
        Time from each beam to the next [s]; 0 if all are measured at once.
    stamped_at : float
        Part of the sweep that has passed at the time that the pose of a scan refers to: 0 for the first beam, as in
        ``sensor_msgs/LaserScan``, 0.5 for the middle one.

    Raises
    ------
    InvalidInput
        A number is not finite, there are no beams or too many, or they cover more than one turn.
    """

    angle_min: float
    angle_increment: float
    beams: int
    mount: Pose2D = Pose2D(0.0, 0.0, 0.0)
    time_increment: float = 0.0
    stamped_at: float = 0.5

    def __post_init__(self) -> None:
        numbers = (self.angle_min, self.angle_increment, self.time_increment, self.stamped_at)
        if not (all(map(math.isfinite, numbers)) and self.mount.is_finite()):
            raise InvalidInput("the angles, the times and the mount of a laser must be finite numbers")
        if not 1 <= self.beams <= MAX_BEAMS:
            raise InvalidInput(f"a laser must have from 1 to {MAX_BEAMS} beams, not {self.beams}")
        turned = abs(self.angle_increment) * (self.beams - 1)
        if self.angle_increment == 0.0 or turned > 2.0 * math.pi + 1e-3:
            raise InvalidInput(
                f"{self.beams} beams in steps of angle_increment {self.angle_increment:g} cover {turned:.2f} rad: "
                "a scan covers more than 0 rad and at most one turn"
            )
        if self.time_increment < 0.0 or not 0.0 <= self.stamped_at <= 1.0:
            raise InvalidInput("time_increment of a laser must not be negative, and stamped_at must be from 0 to 1")

    @property
    def beams_per_radian(self) -> float:
        """Number of beams per radian; negative if the laser turns clockwise."""
        return 1.0 / self.angle_increment

    @property
    def beams_per_turn(self) -> int:
        """Number of beams of a full turn."""
        return round(2.0 * math.pi / abs(self.angle_increment))
