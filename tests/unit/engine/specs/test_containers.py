"""Specifications of containers, and names of a robot's frames."""

import msgspec
import pytest
from msgspec.structs import replace

from engine.specs.containers import ContainerSpec, MapVersion, base_frame
from tests.support.engine.specs import (
    coordinator_spec,
    mapping_spec,
    planning_spec,
    robot_config,
    robot_spec,
    traffic_spec,
)


def test_containers_of_a_map_version_are_one_group() -> None:
    specs = (robot_spec("c1"), robot_spec("c2", robot="tb2"), planning_spec("p1"))
    assert {spec.group for spec in specs} == {"house@v1"}
    assert replace(specs[0], container_group="east").group == "east"


def test_robots_that_make_maps_of_the_same_name_have_nothing_to_share() -> None:
    specs = [mapping_spec(robot=robot, user=user) for robot, user in (("tb1", "ann"), ("tb2", "ann"), ("tb1", "bob"))]
    assert len({spec.group for spec in specs}) == 3
    assert all(spec.maps for spec in specs)
    assert not any(spec.maps for spec in (robot_spec(), planning_spec()))


def test_the_nodes_of_a_group_are_containers_of_their_own_kind_with_checkpoints_of_their_own() -> None:
    specs = [robot_spec(), planning_spec(), coordinator_spec(), traffic_spec()]
    assert [spec.kind for spec in specs] == ["robot", "planning", "coordinator", "traffic"]
    assert [spec.group_node for spec in specs] == ["", "", "people", "traffic"]
    assert len({spec.checkpoint_name for spec in specs}) == 4
    assert traffic_spec().checkpoint_name == traffic_spec("t2", version=MapVersion("house", "v2")).checkpoint_name
    assert traffic_spec().checkpoint_name != traffic_spec(version=MapVersion("depot", "v1")).checkpoint_name


def test_a_spec_of_an_earlier_release_has_no_traffic_node() -> None:
    earlier = {name: value for name, value in msgspec.to_builtins(coordinator_spec()).items() if name != "traffic"}
    assert msgspec.convert(earlier, ContainerSpec) == coordinator_spec()


@pytest.mark.parametrize(
    ("amcl", "frame"),
    [
        ({}, "base_link"), ({"base_frame_id": "base_footprint"}, "base_footprint"),
        ({"tf_prefix": "robot1"}, "robot1/base_link"), ({"base_frame_id": "/a/base", "tf_prefix": "b"}, "a/base"),
        ({"base_frame_id": 7}, "base_link"), ({"tf_prefix": None}, "base_link"), ("nonsense", "base_link"),
    ],
)  # fmt: skip
def test_the_base_has_the_frame_of_the_parameters(amcl: object, frame: str) -> None:
    assert base_frame(robot_config(parameters={"amcl": amcl})) == frame


def test_the_base_of_a_robot_that_makes_a_map_has_the_frame_of_grid_slam() -> None:
    parameters = {"amcl": {"base_frame_id": "a"}, "grid_slam": {"base_frame": "b", "tf_prefix": "robot1"}}
    assert base_frame(robot_config(parameters=parameters, new_map="office-2")) == "robot1/b"
    assert base_frame(robot_config(parameters=parameters)) == "a"


def test_a_place_that_only_plans_has_the_usual_frame() -> None:
    assert base_frame(None) == base_frame(robot_config()) == "base_link"
