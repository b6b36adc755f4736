"""Inputs of a robot's map layers, and the filters of its plans."""

import pytest

from engine.specs.containers import ContainerSpec, MapVersion
from engine.specs.robot_layers import filters_of, layers_of
from ppaas.costmap.global_parameters import CostParameters
from ppaas.errors import InvalidParameter
from tests.support.engine.specs import HOUSE, planning_spec, robot_config

KEPT, SLOW = MapVersion("kept", "v3"), MapVersion("slow", "v1")


def test_a_planning_container_has_no_filters() -> None:
    layers = layers_of(planning_spec())
    assert (layers.robot_radius, layers.masks, layers.heights) == (0.18, {}, None)
    assert filters_of(layers) == {}


def test_costs_of_the_global_costmap_are_those_of_the_robots_file() -> None:
    given = {"global_costmap": {"inflation_radius": 0.3, "cost_scaling_factor": 10.0, "robot_radius": 0.2}}
    layers = layers_of(ContainerSpec("c1", "ann", HOUSE, 1.0, robot_config(parameters=given)))
    assert (layers.robot_radius, layers.costs) == (0.2, CostParameters(inflation_radius=0.3))
    assert filters_of(layers) == {"global_costmap": {"inflation_radius": 0.3}}
    with pytest.raises(InvalidParameter, match="inflation_radius must be from 0 to 100"):
        wrong = robot_config(parameters={"global_costmap": {"inflation_radius": -1}})
        layers_of(ContainerSpec("c1", "ann", HOUSE, 1.0, wrong))


def test_plans_depend_on_the_keepout_filter_and_not_on_the_speed_filter() -> None:
    masks = {"keepout_filter": KEPT, "speed_filter": SLOW}
    robot = robot_config(model="turtlebot3_burger", masks=masks, in_space=True)
    layers = layers_of(ContainerSpec("c1", "ann", HOUSE, 1.0, robot))
    assert (layers.map, layers.robot_radius, layers.masks, layers.heights) == (HOUSE, 0.105, masks, (None, 0.192))
    assert filters_of(layers) == {"keepout_filter": "kept@v3", "voxel_layer": (None, 0.192)}
    slowed = robot_config(masks={"speed_filter": SLOW})
    assert filters_of(layers_of(ContainerSpec("c1", "ann", HOUSE, 1.0, slowed))) == {}
