"""The body that a clone plans and drives for: of its model, of its URDF, and of what its parameters say."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.parameters import Parameters, read_parameters
from ppaas.robot_model.description import RobotDescription, circumscribed_radius
from ppaas.robot_model.known_models import RobotModel, robot_model

COSTMAP, VOXEL_LAYER = "global_costmap", "voxel_layer"

MAX_RADIUS = 100.0


class FootprintParameters(Parameters, frozen=True):
    """Of the global costmap, with the names of costmap_2d [m]; what is left out, URDF or model say.

    Parameters
    ----------
    robot_radius : float, optional
        Of the disc that the robot is for the map and the controller.
    footprint : tuple of (x, y)
        Corners of the outline; the disc is the one around it, unless ``robot_radius`` is given too.
    """

    robot_radius: float | None = None
    footprint: tuple[tuple[float, float], ...] = ()


class VoxelLayerParameters(Parameters, frozen=True):
    """Of the layer that an octomap makes, with the names of costmap_2d.

    Parameters
    ----------
    enabled : bool
        Whether the robot keeps clear of what the octomap of its map has at its height.
    min_obstacle_height : float, optional
        What does not reach higher is in nobody's way [m]; without it, one voxel of the octomap.
    max_obstacle_height : float, optional
        What begins higher is in nobody's way [m]; without it, the height of the robot, if that is known.
    """

    enabled: bool = True
    min_obstacle_height: float | None = None
    max_obstacle_height: float | None = None

    def __post_init__(self) -> None:
        """Check the ranges."""
        low, high = self.min_obstacle_height, self.max_obstacle_height
        for name, value in (("min_obstacle_height", low), ("max_obstacle_height", high)):
            if value is not None and not math.isfinite(value):
                raise InvalidParameter(f"{name} must be finite, not {value}")
        if high is not None and high <= (low or 0.0):
            raise InvalidParameter(f"max_obstacle_height must be above {low or 0.0:g} m, not {high:g}")


def robot_body(
    model: str, urdf: RobotDescription | None = None, parameters: Mapping[str, Any] | None = None
) -> RobotModel:
    """Return the body of a robot: what its parameters say goes before its URDF, and that before its model.

    The disc is the one that holds the robot however it turns. The speed is that of the wheels, and so is the turn up to
    that of the model: what wheels allow on the spot may be more than localization can follow.

    Parameters
    ----------
    model : str
        By its name.
    urdf : RobotDescription, optional
    parameters : mapping, optional
        Of the robot's file, of which ``global_costmap`` counts here.

    Raises
    ------
    NotFound
        No such model; the text lists those there are.
    InvalidParameter
        The radius or the footprint that the parameters give is none.
    """
    body = robot_model(model)
    if urdf is not None:
        body = _as_described(body, urdf)
    said = read_parameters(FootprintParameters, COSTMAP, (parameters or {}).get(COSTMAP, {}))
    if said.footprint:
        body = replace(body, footprint=said.footprint, robot_radius=_radius_around(said.footprint))
    if said.robot_radius is not None:
        body = replace(body, robot_radius=said.robot_radius)
    if not 0.0 <= body.robot_radius < MAX_RADIUS:
        raise InvalidParameter(f"the radius of a robot is from 0 to {MAX_RADIUS:g} m, not {body.robot_radius}")
    return body


def robot_heights(body: RobotModel, parameters: Mapping[str, Any]) -> tuple[float | None, float] | None:
    """Return from where to where something in space is in the way of a robot [m]; None where nothing is looked for.

    Without a lowest height it is for the octomap to say.

    Raises
    ------
    InvalidParameter
        What the parameters say of heights is none.
    """
    said = read_parameters(VoxelLayerParameters, VOXEL_LAYER, parameters.get(VOXEL_LAYER, {}))
    highest = body.height if said.max_obstacle_height is None else said.max_obstacle_height
    return (said.min_obstacle_height, highest) if said.enabled and highest is not None else None


def _as_described(body: RobotModel, urdf: RobotDescription) -> RobotModel:
    limits = body.limits
    if urdf.max_vel_x is not None:
        limits = replace(limits, max_vel_x=urdf.max_vel_x)
    if urdf.max_vel_theta is not None:
        limits = replace(limits, max_vel_theta=min(urdf.max_vel_theta, limits.max_vel_theta))
    laser = next((sensor for sensor in urdf.sensors if sensor.kind == "laser"), None)
    if laser is not None:
        x, y, _, _, _, yaw = laser.pose
        body = replace(body, laser=Pose2D(x, y, yaw), laser_frame=laser.link)
    if urdf.circumscribed_radius is not None:
        body = replace(body, robot_radius=urdf.circumscribed_radius, footprint=urdf.footprint)
    return replace(body, limits=limits, height=body.height if urdf.height is None else urdf.height)


def _radius_around(footprint: tuple[tuple[float, float], ...]) -> float:
    if len(footprint) < 3 or not all(math.isfinite(number) for corner in footprint for number in corner):
        raise InvalidParameter("footprint must be a list of three corners x, y [m] or more")
    return circumscribed_radius(footprint)
