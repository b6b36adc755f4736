"""Robot models that are known by name: the data that a clone needs of its robot's body."""

from dataclasses import dataclass

from ppaas.controllers.base import VelocityLimits
from ppaas.errors import NotFound
from ppaas.geometry import Pose2D, quaternion_of
from ppaas.transforms.spatial import Rigid


@dataclass(frozen=True, slots=True)
class RobotModel:
    """Body of a robot.

    Parameters
    ----------
    name : str
        Name of the model in robot files.
    robot_radius : float
        Radius of the circular footprint [m].
    limits : VelocityLimits
        Limits of velocity and acceleration of the base.
    laser : Pose2D
        Pose of the laser in the base frame [m, rad].
    laser_frame : str
        Frame of scans, if it is not the base frame.
    footprint : tuple of (x, y)
        Corners of the outline in the base frame [m]; empty if the footprint is the circle.
    inner_radius : float, optional
        Radius of the largest disc around the origin within the footprint, if it is noticeably smaller than
        ``robot_radius`` and that is the circumscribed radius [m].
    height : float, optional
        Height from the ground to the top [m].
    frames : tuple of (str, Rigid)
        Frames of the robot's body by its URDF, with their poses in the base frame; empty without a URDF.
    """

    name: str
    robot_radius: float
    limits: VelocityLimits
    laser: Pose2D = Pose2D(0.0, 0.0, 0.0)
    laser_frame: str = "base_scan"
    footprint: tuple[tuple[float, float], ...] = ()
    inner_radius: float | None = None
    height: float | None = None
    frames: tuple[tuple[str, Rigid], ...] = ()

    def frames_with(self, laser_frame: str = "") -> dict[str, Rigid]:
        """Return the frames of the body with the frame of its laser, which may be named differently, by their names."""
        x, y, theta = self.laser
        laser = Rigid(x, y, 0.0, *quaternion_of(theta))
        found = dict(self.frames) or {self.laser_frame: laser}
        return found | {laser_frame: found.get(self.laser_frame, laser)} if laser_frame else found


PLANNING_MODEL = "turtlebot2"
"""Default robot model for planning."""

# Sources: limits from the makers' navigation packages, laser poses from their URDF files, heights from data sheets.
_MODELS = {
    model.name: model
    for model in (
        RobotModel("turtlebot2", 0.18, VelocityLimits(max_vel_x=0.65, max_vel_theta=1.8), height=0.42),
        RobotModel(
            "turtlebot3_burger",
            0.105,
            VelocityLimits(max_vel_x=0.22, max_vel_theta=2.75, acc_lim_x=2.5, acc_lim_theta=3.2),
            laser=Pose2D(-0.032, 0.0, 0.0),
            height=0.192,
        ),
        RobotModel(
            "turtlebot3_waffle",
            0.22,
            VelocityLimits(max_vel_x=0.26, max_vel_theta=1.82, acc_lim_x=2.5, acc_lim_theta=3.2),
            laser=Pose2D(-0.064, 0.0, 0.0),
            height=0.141,
        ),
    )
}


def model_names() -> tuple[str, ...]:
    """Return the sorted names of all known robot models."""
    return tuple(sorted(_MODELS))


def robot_model(name: str) -> RobotModel:
    """Return a robot model by its name.

    Raises
    ------
    NotFound
        No model has that name; the text lists the names.
    """
    if name not in _MODELS:
        raise NotFound("robot model", name, model_names())
    return _MODELS[name]
