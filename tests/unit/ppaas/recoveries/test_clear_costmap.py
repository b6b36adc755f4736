import pytest

from ppaas.recoveries import create
from tests.support.world.recovering import MIDDLE, Run


@pytest.mark.parametrize(
    ("parameters", "area"),
    [
        ({}, (MIDDLE, 3.0, "both")),
        ({"reset_distance": 0.0}, (MIDDLE, 0.0, "both")),
        ({"affected_maps": "local", "layer_names": ["obstacle_layer"]}, (MIDDLE, 3.0, "local")),
    ],
)
def test_what_is_far_is_forgotten_once_and_the_robot_stands(parameters, area):
    run = Run(create("clear_costmap_recovery", **parameters))
    assert run.to_the_end() == 0.0
    assert run.cleared == [area]
    assert not run.velocities


def test_without_layers_nothing_is_forgotten():
    run = Run(create("clear_costmap_recovery", layer_names=[]))
    run.to_the_end()
    assert not run.cleared
