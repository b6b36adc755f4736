"""Body of a robot: merges its model, its URDF and its parameters."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ppaas.costmap.global_parameters import MAX_RADIUS, GlobalCostmapParameters
from ppaas.errors import InvalidParameter
from ppaas.footprints import Footprint, check_corners, disc_outline, goes_around
from ppaas.geometry import Pose2D, convex_outline
from ppaas.parameters import FOOTPRINT, Parameters, read_parameters
from ppaas.robot_model.description import RobotDescription, SensorFrame, circumscribed_radius, inscribed_radius
from ppaas.robot_model.known_models import RobotModel, robot_model
from ppaas.robot_model.sensors import LASER

OBLONG = 0.03
"""Difference of the radii of a footprint from which the disc around it is too wide for some passages [m]."""

COSTMAP, VOXEL_LAYER = "global_costmap", "voxel_layer"
"""Names of the parameters below in a robot's file."""


class VoxelLayerParameters(Parameters, frozen=True):
    """Parameters of the layer made from an octomap, named as in costmap_2d.

    Parameters
    ----------
    enabled : bool
        Whether the robot avoids what the octomap of its map contains at the robot's height.
    min_obstacle_height : float, optional
        Obstacles that are not higher than this are ignored [m]; default: one voxel of the octomap.
    max_obstacle_height : float, optional
        Obstacles that begin above this are ignored [m]; default: the height of the robot, if known.
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
    """Return the body of a robot: parameters take precedence over its URDF, and that over its model.

    The radius is the circumscribed circle's. Speeds come from the wheels, but are at most the model's: many files
    have placeholders as limits, and wheels may turn a robot in place faster than localization can follow.

    Parameters
    ----------
    model : str
        Name of the model.
    urdf : RobotDescription, optional
    parameters : mapping, optional
        Parameters of the robot's file, of which ``global_costmap`` is used.

    Raises
    ------
    NotFound
        There is no such model; the text lists those that exist.
    InvalidParameter
        The radius or the footprint in the parameters is invalid.
    """
    body = robot_model(model)
    if urdf is not None:
        body = _as_described(body, urdf)
    given = costmap_parameters(parameters or {})
    if given.footprint:
        check_corners(given.footprint)
        body = _with_footprint(body, given.footprint)
    if given.robot_radius is not None:
        body = replace(body, robot_radius=given.robot_radius, inner_radius=None)
    if not 0.0 <= body.robot_radius < MAX_RADIUS:
        raise InvalidParameter(f"robot_radius must be from 0 to {MAX_RADIUS:g} m, not {body.robot_radius}")
    return body


def with_load(
    model: str, urdf: RobotDescription | None, parameters: Mapping[str, Any], load: Footprint
) -> dict[str, Any]:
    """Return the parameters of a robot while it carries a load: its outline is that of both, for all nodes.

    Parameters
    ----------
    model, urdf, parameters
        As of `robot_body`.
    load : Footprint
        Outline of the load in the robot's frame [m]; empty for none.

    Raises
    ------
    NotFound, InvalidParameter
        As `robot_body` raises it.
    """
    if not load:
        return dict(parameters)
    body = robot_body(model, urdf, parameters)
    outline = convex_outline([*(body.footprint or disc_outline(body.robot_radius)), *load]).tolist()
    others = {name: _without_outline(values) for name, values in parameters.items()}
    return others | {COSTMAP: {**others.get(COSTMAP, {}), FOOTPRINT: outline}}


def _without_outline(values: Any) -> Any:
    """Return the parameters of a node or plug-in without an outline of the robot."""
    if not isinstance(values, dict):
        return values
    return {name: value for name, value in values.items() if name not in (FOOTPRINT, "robot_radius")}


def costmap_parameters(parameters: Mapping[str, Any]) -> GlobalCostmapParameters:
    """Return the parameters of the global costmap in the parameters of a robot's file.

    Raises
    ------
    InvalidParameter
        One of them is unknown, of the wrong type or out of range.
    """
    return read_parameters(GlobalCostmapParameters, COSTMAP, parameters.get(COSTMAP, {}))


def robot_heights(body: RobotModel, parameters: Mapping[str, Any]) -> tuple[float | None, float] | None:
    """Return the lowest and highest height of obstacles for a robot [m], or None if the octomap is not used.

    If the lowest height is None, it depends on the octomap.

    Raises
    ------
    InvalidParameter
        The parameters of the voxel layer are invalid.
    """
    given = read_parameters(VoxelLayerParameters, VOXEL_LAYER, parameters.get(VOXEL_LAYER, {}))
    highest = body.height if given.max_obstacle_height is None else given.max_obstacle_height
    return (given.min_obstacle_height, highest) if given.enabled and highest is not None else None


def _as_described(body: RobotModel, urdf: RobotDescription) -> RobotModel:
    limits = body.limits
    if urdf.max_vel_x is not None:
        limits = replace(limits, max_vel_x=min(urdf.max_vel_x, limits.max_vel_x))
    if urdf.max_vel_theta is not None:
        limits = replace(limits, max_vel_theta=min(urdf.max_vel_theta, limits.max_vel_theta))
    laser = _laser_of(urdf)
    if laser is not None:
        x, y, _, _, _, yaw = laser.pose
        body = replace(body, laser=Pose2D(x, y, yaw), laser_frame=laser.link)
    if urdf.footprint:
        body = _with_footprint(body, urdf.footprint)
    return replace(body, limits=limits, height=body.height if urdf.height is None else urdf.height, frames=urdf.frames)


def _laser_of(urdf: RobotDescription) -> SensorFrame | None:
    """Return the laser that is most level, the first of these, if there is one."""
    lasers = [sensor for sensor in urdf.sensors if sensor.kind == LASER]
    poses = dict(urdf.frames)
    return min(lasers, key=lambda laser: round(poses[laser.link].tilt, 2) if laser.link in poses else 0.0, default=None)


def _with_footprint(body: RobotModel, footprint: Footprint) -> RobotModel:
    """Return a body with a footprint and its circumscribed radius, and the inner radius if that is smaller.

    A footprint that does not go around the origin is a disc for local planners, and so for planners too.
    """
    hull = convex_outline(footprint)
    inner, radius = inscribed_radius(tuple((x, y) for x, y in hull.tolist())), circumscribed_radius(footprint)
    oblong = goes_around(footprint) and 0.0 < inner < radius - OBLONG
    return replace(body, footprint=footprint, robot_radius=radius, inner_radius=inner if oblong else None)
