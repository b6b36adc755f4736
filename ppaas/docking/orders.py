"""Facts that state machines of docking take, and orders that they return."""

from dataclasses import dataclass

from ppaas.controllers.base import Velocity
from ppaas.docking.detection.base import DockView
from ppaas.docking.dock import MappedDock
from ppaas.docking.failures import DockingFailure
from ppaas.geometry import Pose2D


@dataclass(frozen=True, slots=True)
class Sight:
    """What the robot knows at a time.

    Parameters
    ----------
    now : float
        Time [s].
    odometry : Pose2D
        Pose of the robot in the odometry frame, which does not jump.
    map_in_odom : Pose2D, optional
        Frame of the map in the odometry frame; None as long as the robot is not localized.
    view : DockView, optional
        What it senses; None if nothing is new.
    held : str
        Why the robot must stand, in words; empty if it may drive.
    lifted : bool, optional
        Whether its lift is up; None as long as it does not report that.
    """

    now: float
    odometry: Pose2D
    map_in_odom: Pose2D | None = None
    view: DockView | None = None
    held: str = ""
    lifted: bool | None = None


@dataclass(frozen=True, slots=True)
class DriveTo:
    """Order to drive to a pose in the frame of the map, with obstacles in mind."""

    pose: Pose2D


@dataclass(frozen=True, slots=True)
class Docked:
    """The robot is docked; a dock that charges charges it. ``pose`` is the robot's in the odometry frame."""

    dock: MappedDock
    pose: Pose2D


Order = Velocity | DriveTo | Docked | DockingFailure
"""What the robot does now; the last two end the goal. While Move Base drives, velocities are zero and not sent."""

STAND = Velocity()
