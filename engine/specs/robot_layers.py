"""Map layers that a container needs, by its robot."""

from typing import Any

import msgspec

from engine.specs.containers import ContainerSpec, LayerSpec
from ppaas.clone.robot_body import COSTMAP, VOXEL_LAYER, costmap_parameters, robot_body, robot_heights
from ppaas.clone.robot_body import with_load as parameters_with_load
from ppaas.footprints import Footprint
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
    costs = costmap_parameters(robot.parameters).costs
    return LayerSpec(spec.map, body.robot_radius, robot.masks, heights, costs)


def filters_of(layers: LayerSpec) -> dict[str, Any]:
    """Return the settings, besides the radius, on which the costs of a robot's map depend: conditions of its plans."""
    mask = layers.masks.get(KEEPOUT_FILTER)
    filters: dict[str, Any] = {} if mask is None else {KEEPOUT_FILTER: f"{mask.id}@{mask.version}"}
    if layers.heights is not None:
        filters[VOXEL_LAYER] = layers.heights
    if layers.costs.changed:
        filters[COSTMAP] = layers.costs.changed
    return filters


def with_load(spec: ContainerSpec, bare: ContainerSpec, load: Footprint) -> ContainerSpec:
    """Return a spec whose robot carries a load.

    Parameters
    ----------
    spec : ContainerSpec
    bare : ContainerSpec
        The spec with the parameters of the robot without a load.
    load : Footprint
        Outline of the load in the robot's frame [m]; empty for none.

    Raises
    ------
    NotFound, InvalidParameter
        As `layers_of` raises it.
    """
    if spec.robot is None or bare.robot is None:
        return spec
    parameters = parameters_with_load(bare.robot.model, bare.robot.urdf, bare.robot.parameters, load)
    return msgspec.structs.replace(spec, robot=msgspec.structs.replace(spec.robot, parameters=parameters))
