"""Names of a robot's frames, by its configuration."""

import pytest

from engine.specs.containers import base_frame
from tests.support.engine.specs import robot_config


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
