"""Robot models."""

import pytest

from ppaas.errors import NotFound
from ppaas.robot_model.known_models import model_names, robot_model


def test_turtlebot2_has_the_manufacturers_values():
    model = robot_model("turtlebot2")
    assert (model.robot_radius, model.limits.max_vel_x) == (0.18, 0.65)


def test_every_model_is_found_by_its_name():
    assert [robot_model(name).name for name in model_names()] == list(model_names())


def test_an_unknown_model_is_refused_with_the_known_ones():
    with pytest.raises(NotFound, match=r"unknown robot model 'roomba'; known: .*turtlebot2"):
        robot_model("roomba")
