"""Robot models that are known by name: what a clone must know of its robot's body."""

from dataclasses import dataclass

from ppaas.controllers.base import VelocityLimits
from ppaas.errors import NotFound
from ppaas.geometry import Pose2D


@dataclass(frozen=True, slots=True)
class RobotModel:
    """The body of a robot.

    Parameters
    ----------
    name : str
        As robot files give it.
    robot_radius : float
        Of the round footprint [m].
    limits : VelocityLimits
        What the base can do.
    laser : Pose2D
        Of the laser in the frame of the base [m, rad].
    laser_frame : str
        What scans call their frame, if not that of the base.
    footprint : tuple of (x, y)
        Corners of its outline in the frame of the base [m]; none where its disc says all.
    height : float, optional
        From the ground to its top, if it is known [m].
    """

    name: str
    robot_radius: float
    limits: VelocityLimits
    laser: Pose2D = Pose2D(0.0, 0.0, 0.0)
    laser_frame: str = "base_scan"
    footprint: tuple[tuple[float, float], ...] = ()
    height: float | None = None


PLANNING_MODEL = "turtlebot2"
"""The robot for which paths are planned when a program names none."""

# Limits as the makers' navigation packages give them; laser poses as their URDF files do; heights as data sheets do.
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
    """Return the names of the robot models known."""
    return tuple(sorted(_MODELS))


def robot_model(name: str) -> RobotModel:
    """Return a robot model by its name.

    Raises
    ------
    NotFound
        None of that name; the text lists those there are.
    """
    if name not in _MODELS:
        raise NotFound("robot model", name, model_names())
    return _MODELS[name]
