"""Specifications of containers: what follows from the robot and its map."""

from msgspec.structs import replace

from tests.support.engine.specs import mapping_spec, planning_spec, robot_spec


def test_containers_of_a_map_version_are_one_group() -> None:
    specs = (robot_spec("c1"), robot_spec("c2", robot="tb2"), planning_spec("p1"))
    assert {spec.group for spec in specs} == {"house@v1"}
    assert replace(specs[0], container_group="east").group == "east"


def test_robots_that_make_maps_of_the_same_name_have_nothing_to_share() -> None:
    specs = [mapping_spec(robot=robot, user=user) for robot, user in (("tb1", "ann"), ("tb2", "ann"), ("tb1", "bob"))]
    assert len({spec.group for spec in specs}) == 3
    assert all(spec.maps for spec in specs)
    assert not any(spec.maps for spec in (robot_spec(), planning_spec()))
