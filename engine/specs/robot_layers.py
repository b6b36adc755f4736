"""Map layers that a container needs, by its robot."""

from typing import Any

from engine.specs.containers import ContainerSpec, LayerSpec
from ppaas.clone.robot_body import VOXEL_LAYER, robot_body, robot_heights
from ppaas.nodes.map_server.costmap_filters import KEEPOUT_FILTER
from ppaas.robot_model.known_models import PLANNING_MODEL


def layers_of(spec: ContainerSpec) -> LayerSpec:
    """Return the inputs of the map layers of a container.

    Raises
    ------
    NotFound
        The model of the robot is unknown.
    InvalidParameter
        The parameters of its body are invalid.
    """
    robot = spec.robot
    if robot is None:
        return LayerSpec(spec.map, robot_body(PLANNING_MODEL).robot_radius)
    body = robot_body(robot.model, robot.urdf, robot.parameters)
    heights = robot_heights(body, robot.parameters) if robot.in_space else None
    return LayerSpec(spec.map, body.robot_radius, robot.masks, heights)


def filters_of(layers: LayerSpec) -> dict[str, Any]:
    """Return the filters that close parts of the map to a robot, by name, as conditions of its plans."""
    mask = layers.masks.get(KEEPOUT_FILTER)
    filters: dict[str, Any] = {} if mask is None else {KEEPOUT_FILTER: f"{mask.id}@{mask.version}"}
    return filters if layers.heights is None else filters | {VOXEL_LAYER: layers.heights}
